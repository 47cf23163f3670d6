// sim8: independent simulator. Winkler pads, Maxwell-slip (Iwan) bristles, implicit dynamic Newton.
#include <cstdio>
#include <cstdlib>
#include <cmath>
#include <cstring>
#include <string>
#include <vector>
#include <map>
#include <random>
#include <algorithm>
#include <array>
#include <sys/stat.h>
using namespace std;
typedef array<double,3> V; typedef array<array<double,3>,3> M;
static V operator+(V a,V b){return {a[0]+b[0],a[1]+b[1],a[2]+b[2]};}
static V operator-(V a,V b){return {a[0]-b[0],a[1]-b[1],a[2]-b[2]};}
static V operator*(double s,V a){return {s*a[0],s*a[1],s*a[2]};}
static double dot(V a,V b){return a[0]*b[0]+a[1]*b[1]+a[2]*b[2];}
static V cross(V a,V b){return {a[1]*b[2]-a[2]*b[1],a[2]*b[0]-a[0]*b[2],a[0]*b[1]-a[1]*b[0]};}
static double nrm(V a){return sqrt(dot(a,a));}
static V mul(const M&m,V a){return {dot(m[0],a),dot(m[1],a),dot(m[2],a)};}
static V mulT(const M&m,V a){V r;for(int i=0;i<3;i++)r[i]=m[0][i]*a[0]+m[1][i]*a[1]+m[2][i]*a[2];return r;}
static M mm(const M&a,const M&b){M r;for(int i=0;i<3;i++)for(int j=0;j<3;j++)r[i][j]=a[i][0]*b[0][j]+a[i][1]*b[1][j]+a[i][2]*b[2][j];return r;}
static M I3(){return {{{1,0,0},{0,1,0},{0,0,1}}};}
static M rexp(V w){double t=nrm(w);M K={{{0,-w[2],w[1]},{w[2],0,-w[0]},{-w[1],w[0],0}}};M K2=mm(K,K);
 double a=t<1e-6?1-t*t/6:sin(t)/t,b=t<1e-6?0.5-t*t/24:(1-cos(t))/(t*t);M r=I3();
 for(int i=0;i<3;i++)for(int j=0;j<3;j++)r[i][j]+=a*K[i][j]+b*K2[i][j];return r;}
static array<double,4> quat(const M&r){double w=sqrt(max(0.0,1+r[0][0]+r[1][1]+r[2][2]))/2;array<double,4> q;
 if(w>0.1){q={w,(r[2][1]-r[1][2])/(4*w),(r[0][2]-r[2][0])/(4*w),(r[1][0]-r[0][1])/(4*w)};}
 else {double y=sqrt(max(0.0,1-r[0][0]+r[1][1]-r[2][2]))/2;q={(r[0][2]-r[2][0])/(4*y),(r[0][1]+r[1][0])/(4*y),y,(r[1][2]+r[2][1])/(4*y)};}
 return q;}
static mt19937_64 rng; 
static double U(double a,double b){return a+(b-a)*uniform_real_distribution<double>(0,1)(rng);}
static double LU(double a,double b){return exp(U(log(a),log(b)));}
static double G1(){return normal_distribution<double>(0,1)(rng);}
static int RI(int n){return (int)(U(0,1)*n)%n;}
static double sgn(){return U(0,1)<0.5?-1:1;}
static double clipn(double s){double g;do g=G1();while(fabs(g)>2.5);return s*g;}

static map<string,map<string,double>> E;
static bool has(const char*i){return E.count(i);}
static double e(const char*i,const char*p,double n=0){auto a=E.find(i);if(a==E.end())return n;auto b=a->second.find(p);return b==a->second.end()?n:b->second;}

const int NP=19,NE=3;
struct Patch{double x,z,w;};
struct Bris{double f[NE][2];};
struct Cond{int prim;double grip,speed,slope,off;};
struct Set{
 double L,side,mass,dia,K,knr,rate,stiffe,muf,mup,kp,ktp,tipr,linelen; int kind; // 0 plane 1 plane+pivot 2 point 3 line on end 4 pivot
 Patch pad[2][NP]; double ksh[NE],ysh[NE]; V padc[2]; double yoff;
 double ffn,ffu,ftn,ftu,pfn,pfu,ptn,ptu,posn,rotn;
 V fb[2],tb[2],pb,ptb; V mis[2],mispu; double gain[2],gainp; double tiltp[3]; V ppos; double lat; 
 double gripf; double creep,creept,armtau,travel; bool pause; double pausemax; double wearn;
} S;

static bool solve7(double A[7][8]){
 for(int c=0;c<7;c++){int p=c;for(int r=c+1;r<7;r++)if(fabs(A[r][c])>fabs(A[p][c]))p=r;
  if(fabs(A[p][c])<1e-300)return false; if(p!=c)for(int k=c;k<8;k++)swap(A[p][k],A[c][k]);
  for(int r=c+1;r<7;r++){double f=A[r][c]/A[c][c];if(f!=0)for(int k=c;k<8;k++)A[r][k]-=f*A[c][k];}}
 for(int c=6;c>=0;c--){for(int k=c+1;k<7;k++)A[c][7]-=A[c][k]*A[k][7];A[c][7]/=A[c][c];}return true;}

struct Sample{double t,grip;V gp;M gr;V op;M orr;V f[2],tq[2],pf,pt;};
static long nfail=0,nstep=0,niter=0;
struct Path{ double t0,T,tp,Tp; double v,dist; double at(double t){ // trapezoid-less constant speed with a pause
  double s=0;double h=dist/2/v; if(t>t0)s+=v*min(t-t0,h); double t1=t0+h+Tp; if(t>t1)s+=v*min(t-t1,h); return s;} };

static vector<Sample> simulate(const Cond&c,int order,double dtf,double mufac[2],double mupfac,double preload[2],double rest0,double gripjit,double &endslip){
 double dt=5e-5*dtf; double side=S.side,m=S.mass*(1+e("mass_error","fraction"));
 double comx=e("mass_error","com_x_m");
 V g={0,0,-9.81}; {V w={e("gravity_tilt","about_x_rad"),e("gravity_tilt","about_y_rad"),0};g=mul(rexp(w),g);}
 V Ib={m*(side*side)/6,m*(S.L*S.L+side*side)/12,m*(S.L*S.L+side*side)/12};
 double Kt=S.K*pow(c.grip/20,S.stiffe),Kn=S.K*S.knr*pow(c.grip/20,S.stiffe);
 double slopef=e("face_tilt","slope_rad");
 bool line=(c.prim==1)||S.kind==3,point=(c.prim==0&&S.kind==2);
 // pusher
 double gap=0.0003; V Pn; M Rp; V Pnom; double facedist; V fm; vector<V> pc; vector<double> pw; double rho=0;
 if(c.prim==1){Pnom={-(S.L/2-0.006)+c.off,0,-side/2-gap};M r={{{0,0,-1},{0,1,0},{1,0,0}}};Rp=r;fm={0,0,-1};facedist=side/2;}
 else {Pnom={-S.L/2-gap,0,c.off};Rp=I3();fm={-1,0,0};facedist=S.L/2; if(point){Pnom[0]-=S.tipr;rho=S.tipr;}}
 {V tl={S.tiltp[0],S.tiltp[1],S.tiltp[2]}; if(!line&&!point){tl[1]+=e("plate_tilt","pitch_rad");tl[2]+=e("plate_tilt","yaw_rad");}
  // line: turn about the contact normal
  if(line)tl[0]+=e("plate_tilt","line_rad");
  Rp=mm(Rp,rexp(tl));}
 V Po=Pnom+S.ppos; V pX={Rp[0][0],Rp[1][0],Rp[2][0]},pY={Rp[0][1],Rp[1][1],Rp[2][1]},pZ={Rp[0][2],Rp[1][2],Rp[2][2]};
 if(line){double h=min(S.linelen,side)/2;for(int i=0;i<7;i++){pc.push_back({0,h*(i-3)/3.0,0});pw.push_back((i==0||i==6?0.5:1)/6.0);}}
 else if(point){pc.push_back({0,0,0});pw.push_back(1);}
 else for(int i=-2;i<=2;i++)for(int j=-2;j<=2;j++){pc.push_back({-S.L/2,side/2*i/2.0,side/2*j/2.0});pw.push_back((abs(i)==2?.5:1)*(abs(j)==2?.5:1)/16.0);}
 int npc=pc.size();
 // state
 V x={0,0,0},v={0,0,0},om={0,0,0};M R=I3(); double G0=c.grip; double w=0.3*G0/Kn;
 static Bris b[2][NP],bn[2][NP]; memset(b,0,sizeof b); vector<array<double,2>> pbz(npc,{0,0}),pbn(npc,{0,0});
 double vs[2][NP];memset(vs,0,sizeof vs); double vsp[32];memset(vsp,0,sizeof vsp);
 double cre[2][2]={{0,0},{0,0}},age[2]={0.1,0.1}; double grip=G0,blx=0; double slipdist=0; double vmean=0;
 double tpre=0.4; Path path; path.t0=rest0; double spd=c.speed; path.v=spd;
 path.dist=c.prim==1?min(S.travel/0.012*0.22,spd*1.3):min(S.travel,spd*1.2); if(c.prim!=1)path.dist=max(path.dist,0.006);
 path.Tp=S.pausemax; double tend=rest0+path.dist/spd+path.Tp+0.3;
 double f1=0,f2=0; // lag states
 V gp0={0,0,0};M gr0=I3(); V xref=x; bool ref=false; vector<Sample> out; double tnext=0; int k=0;
 V z0={0,0,0},lpF[2]={z0,z0},lpT[2]={z0,z0},lpP=z0,lpQ=z0;V lastF[2],lastT[2],lastPF,lastPT;
 double aniso=e("anisotropic_friction","ratio",1); double ra=sqrt(aniso),rb=1/sqrt(aniso); bool an=aniso!=1;
 double lexp=e("load_dependent_friction","exponent");
 double wear=1+e("wear_drift","rate_per_trial")*order; double mis=e("finger_friction_mismatch","mismatch");
 double xs=e("x_direction_sense","asymmetry"),grease=e("x_grease","loss"),grx=e("x_grease","centre_x_m"),grw=e("x_grease","half_width_m",1e-3);
 double Aad=e("adhesion","pull_off_n");
 double ex=e("static_friction","excess"),vst=e("static_friction","stribeck_speed_m_s",0.002),visc=e("viscous_friction","viscosity_s_m");
 double Nlast[2]={G0*0.3,G0*0.3}; double torsr=0; (void)torsr;
 V dxp={0,0,0},dop={0,0,0};
 for(double t=-tpre;t<tend;t+=dt){
  double t1=t+dt; double ramp=min(1.0,max(0.0,(t1+0.35)/0.15));
  // gripper path with arm lag (two first-order filters)
  double cmd=path.at(t1);double al=dt/(dt+S.armtau/2); f1+=al*(cmd-f1); f2+=al*(f1-f2);
  V gp1={0,0,0};M gr1=I3(); if(c.prim==1)gr1=rexp({0,-f2,0}); else gp1={-f2*cos(c.slope),0,f2*sin(c.slope)};
  // grip
  double gx=dot(gp1-x,{R[0][0],R[1][0],R[2][0]}); // finger place along object X
  double tgt=c.grip*(1-e("grip_force_loss","fraction"))-e("grip_force_loss","offset_n");
  tgt*=S.gripf*gripjit;
  if(has("grip_force_lag")){double kn=e("grip_force_lag","knee_m_s",1e-3);tgt*=1-e("grip_force_lag","drop")*vmean/(vmean+kn)-e("grip_force_lag","drop_1_m")*slipdist;}
  if(has("face_tilt"))tgt+=e("face_tilt","grip_gradient_n_m")*gx+e("face_tilt","grip_gradient_1_m")*gx*c.grip;
  if(has("face_waviness"))tgt+=e("face_waviness","grip_n")*sin(2*M_PI*gx/e("face_waviness","wavelength_m",.008)+e("face_waviness","phase_rad"));
  tgt*=0.3+0.7*min(1.0,max(0.0,(t1+tpre)/0.05));
  double gt=max(0.003,e("grip_force_lag","time_s",0.003)); if(t1<0)gt=0.003; grip+=dt/(dt+gt)*(tgt-grip); grip=max(grip,0.5);
  double wavmu=has("face_waviness")?1+e("face_waviness","amplitude")*sin(2*M_PI*gx/e("face_waviness","wavelength_m",.008)+e("face_waviness","phase_rad")):1;
  // friction of patches (lagged)
  double mu[2][NP];
  for(int s=0;s<2;s++){double base=S.muf*mufac[s]*wear*wavmu*(s==0?1+mis:1-mis);
   if(lexp!=0)base*=pow(max(Nlast[s],0.5)/20,-lexp);
   if(has("dwell_strengthening"))base*=1+e("dwell_strengthening","strengthening")*log(1+age[s]/e("dwell_strengthening","cutoff_s",.05));
   for(int i=0;i<NP;i++){double u=base; double sp=vs[s][i]; if(ex!=0)u*=1+ex*exp(-sp/vst); u+=visc*sp;
    double ox=gx+S.pad[s][i].x; u*=1+e("face_tilt","friction_gradient_1_m")*ox;
    if(grease!=0&&s==0&&fabs(ox-grx)<grw)u*=1-grease;
    if(xs!=0){double fz=0;for(int q=0;q<NE;q++)fz+=b[s][i].f[q][1];double fx=0;for(int q=0;q<NE;q++)fx+=b[s][i].f[q][0];double n=sqrt(fx*fx+fz*fz)+1e-3*G0/NP;u*=1-xs*fz/n;}
    mu[s][i]=max(0.01,u);}}
  // gripper-frame quantities
  V ey={gr1[0][1],gr1[1][1],gr1[2][1]},ex_={gr1[0][0],gr1[1][0],gr1[2][0]},ez_={gr1[0][2],gr1[1][2],gr1[2][2]};
  V P0[2][NP],P1[2][NP];
  for(int s=0;s<2;s++)for(int i=0;i<NP;i++){double sg=s==0?1:-1;V l={S.pad[s][i].x,sg*(side/2+slopef*S.pad[s][i].x)+S.yoff,S.pad[s][i].z};P0[s][i]=gp0+mul(gr0,l);P1[s][i]=gp1+mul(gr1,l);}
  // pad base motion: creep, prestress, play
  double db[2][2]={{0,0},{0,0}};
  for(int s=0;s<2;s++){V Fl=mulT(gr1,lastF[s]);double fl[2]={Fl[0],Fl[2]};if(t==-tpre)fl[0]=fl[1]=0;
   for(int q=0;q<2;q++){double target=-fl[q]*S.creep/Kt;double d=(target-cre[s][q])*dt/S.creept;cre[s][q]+=d;db[s][q]+=d;
    if(t1>-0.2&&t1<=-0.1)db[s][q]+=(s==0?1:-1)*preload[q]*S.muf*G0/Kt*dt/0.1;}
   if(s==1&&has("x_jaw_play")){double fp=e("x_jaw_play","drag_n"),gpl=e("x_jaw_play","play_m")/2,F=-fl[0];double d=0;if(fabs(F)>fp)d=(fabs(F)-fp)*(F>0?1:-1)*dt/(Kt*0.004+fp/0.05);
     double nb=min(gpl,max(-gpl,blx+d));db[s][0]+=nb-blx;blx=nb;}}
  // Newton
  double y[7]={dxp[0],dxp[1],dxp[2],dop[0],dop[1],dop[2],0}; bool ok=false;
  V Fs[2],Ts[2],PF,PT;double Nn[2];double vnew[2][NP],vpnew[32];V x1;M R1; V th;
  double best=1e99;int it;
  V Fext={0,0,0};if(has("external_force")){V f0={e("external_force","x_n"),e("external_force","y_n"),e("external_force","z_n")};double n=nrm(f0);if(n>0){double d=ref?dot(x-xref,(1/n)*f0):0;Fext=(ramp*(1-e("external_force","stiffness_n_m")*d/n))*f0;}}
  for(it=0;it<25;it++){
   V dx={y[0],y[1],y[2]};th={y[3],y[4],y[5]};x1=x+dx;R1=mm(rexp(th),R);double w1=w+y[6];
   double A[7][8];memset(A,0,sizeof A);
   V acc=(m/dt)*((1/dt)*dx-v); V com=mul(R1,{comx,0,0}); V W=(m*ramp)*g+Fext; V rf=acc-W;
   // inertia tensor in world
   M Iw;for(int i=0;i<3;i++)for(int j=0;j<3;j++){Iw[i][j]=0;for(int q=0;q<3;q++)Iw[i][j]+=R[i][q]*Ib[q]*R[j][q];}
   V rt=(1/dt)*mul(Iw,(1/dt)*th-om)-cross(com,(m*ramp)*g);
   for(int i=0;i<3;i++){A[i][i]+=m/dt/dt;for(int j=0;j<3;j++)A[3+i][3+j]+=Iw[i][j]/dt/dt;}
   auto addK=[&](const M&K3,V r){ // F=-K3 u, u=dx+th x r ; A += J^T K3 J
    // Jr column j: e_j x r
    M X;V c0=cross({1,0,0},r),c1=cross({0,1,0},r),c2=cross({0,0,1},r);for(int i=0;i<3;i++){X[i][0]=c0[i];X[i][1]=c1[i];X[i][2]=c2[i];}
    M KX=mm(K3,X);for(int i=0;i<3;i++)for(int j=0;j<3;j++){A[i][j]+=K3[i][j];A[i][3+j]+=KX[i][j];
     double a=0,bb=0;for(int q=0;q<3;q++){a+=X[q][i]*K3[q][j];bb+=X[q][i]*KX[q][j];}A[3+i][j]+=a;A[3+i][3+j]+=bb;}};
   for(int s=0;s<2;s++){double sg=s==0?1:-1;Fs[s]={0,0,0};Ts[s]={0,0,0};Nn[s]=0;
    double mn=sqrt(1+slopef*slopef);V n=mul(R1,{slopef/mn,-sg/mn,0});V cen=gp1+mul(gr1,{0,sg*side/2,0});
    for(int i=0;i<NP;i++){V rel=P1[s][i]-x1;V q=mulT(R1,rel);double pen=side/2+slopef*q[0]-sg*q[1]+w1;
     double kn=Kn*S.pad[s][i].w;V u=dx+cross(th,rel);V sl=(P1[s][i]-P0[s][i])-u;double qn=4e-4/dt;double p=kn*(pen+qn*(dot(sl,n)+y[6]));bool con=pen>0&&p>0;if(!con)p=0;kn*=1+qn;
     sl=sl-dot(sl,n)*n;
     double sx=dot(sl,ex_)+db[s][0],sz=dot(sl,ez_)+db[s][1];
     double kt=Kt*S.pad[s][i].w;double tx=0,tz=0,k00=0,k01=0,k11=0,tpx=0,tpz=0,pl=0;
     double Ya=mu[s][i]*(p+(con?Aad*S.pad[s][i].w:0));
     // object X in gripper plane
     double ca=1,sa=0;if(an){V ox={R1[0][0],R1[1][0],R1[2][0]};ca=dot(ox,ex_);sa=dot(ox,ez_);double h=sqrt(ca*ca+sa*sa);ca/=h;sa/=h;}
     for(int el=0;el<NE;el++){double k=kt*S.ksh[el],Y=Ya*S.ysh[el];double ax=b[s][i].f[el][0]+k*sx,az=b[s][i].f[el][1]+k*sz;
      if(!con){bn[s][i].f[el][0]=bn[s][i].f[el][1]=0;continue;}
      double fx=ax,fz=az;
      if(!an){double h=sqrt(ax*ax+az*az);if(h>Y){double d0=ax/h,d1=az/h;fx=Y*d0;fz=Y*d1;double c_=k*Y/h;k00+=c_*(1-d0*d0);k01-=c_*d0*d1;k11+=c_*(1-d1*d1);tpx+=mu[s][i]*S.ysh[el]*d0;tpz+=mu[s][i]*S.ysh[el]*d1;pl+=(h-Y)/k/NE;}
       else{k00+=k;k11+=k;}}
      else{double fa=ca*ax+sa*az,fb=-sa*ax+ca*az;double h=sqrt(fa*fa/ra/ra+fb*fb/rb/rb);
       if(h>Y){double la=0;for(int z=0;z<30;z++){double qa=1+la/ra/ra,qb=1+la/rb/rb;double A_=fa/ra/qa,B_=fb/rb/qb;double gg=A_*A_+B_*B_-Y*Y;double dg=-2*(A_*A_/qa/ra/ra+B_*B_/qb/rb/rb);double d=-gg/dg;la+=d;if(fabs(d)<1e-10*(1+la))break;}
        double qa=1+la/ra/ra,qb=1+la/rb/rb;double ga=fa/qa,gb=fb/qb;fx=ca*ga-sa*gb;fz=sa*ga+ca*gb;pl+=sqrt((ax-fx)*(ax-fx)+(az-fz)*(az-fz))/k/NE;
        // consistent tangent: D=diag(k/q) minus rank one along normal
        double na=ga/ra/ra,nb=gb/rb/rb;double Da=k/qa,Db=k/qb;double den=na*na*Da+nb*nb*Db;double va=Da*na,vb=Db*nb;
        double kaa=Da-va*va/den,kab=-va*vb/den,kbb=Db-vb*vb/den;
        k00+=ca*ca*kaa-2*ca*sa*kab+sa*sa*kbb;k11+=sa*sa*kaa+2*ca*sa*kab+ca*ca*kbb;k01+=ca*sa*(kaa-kbb)+(ca*ca-sa*sa)*kab;
        double c1=Y>0?mu[s][i]*S.ysh[el]/Y:0;tpx+=c1*fx;tpz+=c1*fz;}
       else{k00+=k;k11+=k;}}
      bn[s][i].f[el][0]=fx;bn[s][i].f[el][1]=fz;tx+=fx;tz+=fz;}
     vnew[s][i]=pl/dt; if(!con)continue;
     {double qv=2e-4/dt,ox=0,oz=0;for(int el=0;el<NE;el++){ox+=b[s][i].f[el][0];oz+=b[s][i].f[el][1];}tx+=qv*(tx-ox);tz+=qv*(tz-oz);k00*=1+qv;k01*=1+qv;k11*=1+qv;tpx*=1+qv;tpz*=1+qv;} // damping of the elastic part only
     V F=p*n+tx*ex_+tz*ez_; Fs[s]=Fs[s]+F;Ts[s]=Ts[s]+cross(P1[s][i]-cen,F);Nn[s]+=p;
     rf=rf-F;rt=rt-cross(rel,F);
     V np=n+tpx*ex_+tpz*ez_; M K3;for(int a=0;a<3;a++)for(int c_=0;c_<3;c_++)K3[a][c_]=kn*np[a]*n[c_]+k00*ex_[a]*ex_[c_]+k01*(ex_[a]*ez_[c_]+ez_[a]*ex_[c_])+k11*ez_[a]*ez_[c_];
     addK(K3,rel); V rn=cross(rel,n),rnp=cross(rel,np);
     for(int a=0;a<3;a++){A[a][6]-=kn*np[a];A[3+a][6]-=kn*rnp[a];A[6][a]-=0.5*kn*n[a];A[6][3+a]-=0.5*kn*rn[a];}A[6][6]+=0.5*kn;
    }}
   PF={0,0,0};PT={0,0,0};
   for(int i=0;i<npc;i++){V n,P,rel,tA,tB;double pen;
    if(line||point){V Pw=Po+mul(Rp,pc[i]);n=-1.0*mul(R1,fm);V q=mulT(R1,Pw-x1);pen=rho+facedist-dot(q,fm);P=Pw+rho*n;rel=P-x1;tA=pY-dot(pY,n)*n;tA=(1/nrm(tA))*tA;tB=cross(n,tA);
      for(int d=0;d<3;d++)if(fm[d]==0){double lim=d==0?S.L/2:side/2;if(fabs(q[d])>lim+1e-4)pen=-1;}}
    else{rel=mul(R1,pc[i]);P=x1+rel;n=pX;pen=-dot(P-Po,n);tA=pY;tB=pZ;}
    double kn=S.kp*pw[i];V u=dx+cross(th,rel);double hc=1-20*dot(u,n)/dt;if(pen<=0||hc<=0){pbn[i]={0,0};vpnew[i]=0;continue;}
    double p=kn*pen*hc;kn=kn*hc+kn*pen*20/dt; // Hunt-Crossley
    double k=S.ktp*pw[i];double ax=pbz[i][0]-k*dot(u,tA),az=pbz[i][1]-k*dot(u,tB);double mup=S.mup*mupfac;double Y=mup*p,h=sqrt(ax*ax+az*az);
    double k00=k,k01=0,k11=k,tpx=0,tpz=0,fx=ax,fz=az;if(h>Y){double d0=ax/h,d1=az/h;fx=Y*d0;fz=Y*d1;double c_=k*Y/h;k00=c_*(1-d0*d0);k01=-c_*d0*d1;k11=c_*(1-d1*d1);tpx=mup*d0;tpz=mup*d1;}
    pbn[i]={fx,fz};V F=p*n+fx*tA+fz*tB;PF=PF+F;PT=PT+cross(P-Pnom,F);rf=rf-F;rt=rt-cross(rel,F);
    V np=n+tpx*tA+tpz*tB;M K3;for(int a=0;a<3;a++)for(int c_=0;c_<3;c_++)K3[a][c_]=kn*np[a]*n[c_]+k00*tA[a]*tA[c_]+k01*(tA[a]*tB[c_]+tB[a]*tA[c_])+k11*tB[a]*tB[c_];
    addK(K3,rel);}
   if(has("external_force"))rt=rt-cross(mul(R1,{e("external_force","at_x_m"),0,0}),Fext);
   double rg=0.5*(Nn[0]+Nn[1])-grip;
   double res=max(max(max(fabs(rf[0]),fabs(rf[1])),max(fabs(rf[2]),fabs(rg))),50*max(fabs(rt[0]),max(fabs(rt[1]),fabs(rt[2]))));
   if(res<best)best=res; niter++;
   if(res<(it<12?2e-4:2e-3)){ok=true;break;}
   for(int i=0;i<3;i++){A[i][7]=-rf[i];A[3+i][7]=-rt[i];}A[6][7]=-rg;
   if(!solve7(A))break; double sc=it>=8?(it%2?0.5:0.8):1; for(int i=0;i<7;i++)y[i]+=sc*A[i][7];
  }
  nstep++;if(!ok)nfail++;
  V dx={y[0],y[1],y[2]};
  v=(1/dt)*dx;om=(1/dt)*th;dxp=dx;dop=th;x=x1;R=R1;w+=y[6];memcpy(b,bn,sizeof b);pbz=pbn;
  double vm=0;for(int s=0;s<2;s++){double a=0;for(int i=0;i<NP;i++){double f=dt/(dt+5e-4);vs[s][i]+=f*(vnew[s][i]-vs[s][i]);a+=vs[s][i]*S.pad[s][i].w;}vm+=a/2;
   age[s]+=dt*(1-a*age[s]/e("dwell_strengthening","renewal_m",2e-5));if(age[s]<0)age[s]=0;Nlast[s]=Nn[s];lastF[s]=Fs[s];lastT[s]=Ts[s];}
  vmean=vm;if(t1>0)slipdist+=vm*dt;
  gp0=gp1;gr0=gr1;
  {double a=dt/(dt+1e-3);for(int s=0;s<2;s++){V F=mulT(gr1,Fs[s]),T=mulT(gr1,Ts[s]);lpF[s]=lpF[s]+a*(F-lpF[s]);lpT[s]=lpT[s]+a*(T-lpT[s]);}lpP=lpP+a*(PF-lpP);lpQ=lpQ+a*(PT-lpQ);} // sensor electronics: 1 ms low-pass
  if(!ref&&t1>=0){xref=x;ref=true;}
  if(t1>=tnext-1e-9&&t1>-1e-9){Sample q;q.t=k/S.rate;q.grip=c.grip;q.gp=gp1;q.gr=gr1;q.op=x;q.orr=R;for(int s=0;s<2;s++){q.f[s]=lpF[s];q.tq[s]=lpT[s];}q.pf=lpP;q.pt=lpQ;out.push_back(q);k++;tnext=k/S.rate;}
  if(!(fabs(x[0])<0.2&&fabs(x[1])<0.2&&fabs(x[2])<0.2)){fprintf(stderr,"flew off t=%g\n",t1);break;}
 }
 endslip=slipdist; return out;}

static string js(double v){char b[40];snprintf(b,40,"%.9g",v);return b;}
int main(int argc,char**argv){
 if(argc<6){fprintf(stderr,"sim8 NUM SEED EFFECTS SETDIR KEY\n");return 1;}
 rng.seed(strtoull(argv[2],0,10)); string eff=argv[3],dir=argv[4];
 double dtf=getenv("SIM8_DT")?atof(getenv("SIM8_DT")):1; bool nonoise=getenv("SIM8_NONOISE"); int only=getenv("SIM8_ONLY")?atoi(getenv("SIM8_ONLY")):-1;
 vector<string> ids;{string c;for(char ch:eff+","){if(ch==','){if(c.size()&&c!="none")ids.push_back(c);c="";}else c+=ch;}}
 auto in=[&](const char*s){return find(ids.begin(),ids.end(),s)!=ids.end();};
 // ---- set
 S.kind=vector<int>{0,0,0,1,1,1,2,2,3,4}[RI(10)];
 if(in("plate_tilt")&&(S.kind==2))S.kind=1; 
 bool needlin=in("plate_tilt")||in("face_tilt")||in("x_direction_sense")||in("x_grease")||in("face_waviness")||in("anisotropic_friction");if(needlin&&S.kind==4)S.kind=1;
 S.L=U(0.07,0.12);S.side=U(0.02,0.03);S.dia=U(0.013,min(0.02,S.side-0.003));double rhoM=LU(1000,4000);S.mass=min(0.4,rhoM*S.L*S.side*S.side);
 S.K=LU(2e4,3e6);S.knr=U(1.0,3.0);S.stiffe=U(0,0.33);S.muf=U(0.2,1.0);S.mup=U(0.2,0.6);S.kp=LU(8e5,1e7);S.ktp=S.kp*U(0.5,0.9);S.tipr=U(0.003,0.006);S.linelen=U(0.02,0.032);
 int ng=3+RI(2);double gmin=max(8.0,1.7*S.mass*9.81/(2*S.muf)+(in("external_force")?2.0/S.muf:0)+(in("grip_force_loss")?3:0));gmin=min(gmin,25.0);double glo=U(gmin,max(gmin+1,min(22.0,gmin*1.6))),ghi=U(min(43.0,glo*1.6),45);vector<double> grips;for(int i=0;i<ng;i++)grips.push_back(round(glo*pow(ghi/glo,i/(ng-1.0))));
 S.rate=RI(2)?250:500;
 double a=S.dia/2; 
 // uneven pressure: small gradients, falling to the rim
 double rim=U(0,0.4);
 double po[2]={e("x",""),0};(void)po;
 S.ksh[0]=U(.4,.6);S.ksh[1]=(1-S.ksh[0])*U(.45,.65);S.ksh[2]=1-S.ksh[0]-S.ksh[1];S.ysh[0]=U(.2,.35);S.ysh[1]=U(.25,.38);S.ysh[2]=1-S.ysh[0]-S.ysh[1];
 S.ffn=U(.01,.03);S.ffu=U(.05,.25);S.ftn=U(2e-4,5e-4);S.ftu=U(.001,.003);S.pfn=U(.02,.06);S.pfu=U(.1,.75);S.ptn=U(5e-4,2e-3);S.ptu=U(.005,.037);S.posn=U(15e-6,50e-6);S.rotn=U(1e-4,4e-4);
 for(int s=0;s<2;s++){for(int i=0;i<3;i++){S.fb[s][i]=clipn(S.ffu/3);S.tb[s][i]=clipn(S.ftu/3);S.mis[s][i]=U(-.003,.003);}S.gain[s]=1+clipn(.001);}
 for(int i=0;i<3;i++){S.pb[i]=clipn(S.pfu/3);S.ptb[i]=clipn(S.ptu/3);S.mispu[i]=U(-.003,.003);S.tiltp[i]=U(-2e-4,2e-4);S.ppos[i]=U(-3e-5,3e-5);}S.gainp=1+clipn(.001);
 S.yoff=U(-2e-5,2e-5);S.lat=U(0,.001);S.gripf=1+clipn(.003);S.creep=U(.03,.12);S.creept=U(.2,1.0);S.armtau=U(.01,.03);S.travel=U(.008,.013);S.pause=U(0,1)<0.35||in("dwell_strengthening");S.pausemax=S.pause?U(.3,.7):0;
 if(getenv("SIM8_IDEAL")){for(int s=0;s<2;s++){S.fb[s]=S.tb[s]=S.mis[s]={0,0,0};S.gain[s]=1;}S.pb=S.ptb=S.mispu={0,0,0};S.gainp=1;}
 // ---- effects
 auto st=[&](double typ){return typ*LU(1,4);};
 auto some=[&](const char*id,vector<pair<string,double>> ps,int nmin,int nmax,bool sg){shuffle(ps.begin(),ps.end(),rng);int n=nmin+RI(nmax-nmin+1);n=min(n,(int)ps.size());for(int i=0;i<n;i++)E[id][ps[i].first]=(sg?sgn():1)*st(ps[i].second);};
 for(auto&id:ids){const char*i=id.c_str();
  if(id=="static_friction"){E[i]["excess"]=st(.2);E[i]["stribeck_speed_m_s"]=.002;}
  else if(id=="viscous_friction")E[i]["viscosity_s_m"]=st(2);
  else if(id=="dwell_strengthening"){E[i]["strengthening"]=st(.05);E[i]["cutoff_s"]=.05;E[i]["renewal_m"]=2e-5;}
  else if(id=="load_dependent_friction")E[i]["exponent"]=st(.15);
  else if(id=="anisotropic_friction"){double l=log(1.4)*LU(1,4);E[i]["ratio"]=exp(sgn()*l);}
  else if(id=="finger_friction_mismatch")E[i]["mismatch"]=sgn()*st(.15);
  else if(id=="wear_drift")E[i]["rate_per_trial"]=sgn()*st(.0006);
  else if(id=="torsional_friction"){double v=st(.002);E[i]["radius_change_m"]=U(0,1)<.35?-min(v,.5*a):v;}
  else if(id=="pressure_offset")some(i,{{"offset_x_m",.002},{"offset_z_m",.001}},1,2,true);
  else if(id=="face_tilt"){some(i,{{"slope_rad",.01},{"friction_gradient_1_m",6},{"grip_gradient_n_m",100}},1,1,true);}
  else if(id=="face_waviness"){E[i]["amplitude"]=st(.1);E[i]["wavelength_m"]=U(.004,.01);E[i]["phase_rad"]=U(-3,3);}
  else if(id=="plate_tilt"){if(S.kind==3||S.kind==4)E[i]["line_rad"]=sgn()*st(.01);else some(i,{{"pitch_rad",.01},{"yaw_rad",.01}},1,2,true);}
  else if(id=="adhesion")E[i]["pull_off_n"]=st(1);
  else if(id=="grip_force_loss")some(i,{{"fraction",.1},{"offset_n",1}},1,1,false);
  else if(id=="grip_force_lag"){E[i]["drop"]=st(.12);E[i]["time_s"]=st(.1);E[i]["knee_m_s"]=1e-3;}
  else if(id=="mass_error")some(i,{{"fraction",.1},{"com_x_m",.004}},1,2,true);
  else if(id=="external_force"){some(i,{{"x_n",.5},{"y_n",.5},{"z_n",.5}},1,2,true);E[i]["stiffness_n_m"]=U(0,1)<.5?0:st(20);}
  else if(id=="gravity_tilt")some(i,{{"about_x_rad",.05},{"about_y_rad",.05}},1,2,true);
  else if(id=="sensor_bias"){vector<pair<string,double>> p;for(int s=1;s<3;s++)for(const char*q:{"fx","fy","fz"})p.push_back({"finger"+to_string(s)+"_"+q+"_n",.25});for(int s=1;s<3;s++)for(const char*q:{"tx","ty","tz"})p.push_back({"finger"+to_string(s)+"_"+q+"_nm",.003});some(i,p,1,3,true);}
  else if(id=="sensor_gain")some(i,{{"finger1",.05},{"finger2",.05},{"pusher",.05}},1,2,true);
  else if(id=="sensor_misalignment")some(i,{{"finger1_x_rad",.03},{"finger1_z_rad",.03},{"finger2_x_rad",.03},{"finger2_z_rad",.03},{"pusher_y_rad",.03},{"pusher_z_rad",.03}},1,2,true);
  else if(id=="sensor_crosstalk")some(i,{{"finger1_to_x",.02},{"finger2_to_x",.02},{"finger1_to_z",.02},{"finger2_to_z",.02}},1,2,true);
  else if(id=="mocap_latency")E[i]["latency_s"]=st(.02);
  else if(id=="x_direction_sense")E[i]["asymmetry"]=sgn()*LU(.1,.3);       // friction differs by sense of sliding along gripper Z
  else if(id=="x_jaw_play"){E[i]["play_m"]=LU(1.5e-4,6e-4);E[i]["drag_n"]=U(.2,.6);}
  else if(id=="x_grease"){E[i]["loss"]=LU(.25,.7);E[i]["centre_x_m"]=U(-.006,.012);E[i]["half_width_m"]=U(.003,.006);}
  else if(id=="x_temperature_drift"){E[i]["finger1_fx_n"]=sgn()*LU(.4,1.2);E[i]["finger1_fz_n"]=sgn()*LU(.2,.8);E[i]["trials"]=U(10,40);}
  else {fprintf(stderr,"unknown effect %s\n",i);return 1;}}
 // ---- pads
 for(int s=0;s<2;s++){double aa=a+e("torsional_friction","radius_change_m");double g1=U(-.12,.12),g2=U(-.12,.12);double cx=U(.1e-3,.2e-3),an=U(0,2*M_PI);S.padc[s]={cx*cos(an)+e("pressure_offset","offset_x_m"),0,cx*sin(an)+e("pressure_offset","offset_z_m")};
  double sum=0;int n=0;auto put=[&](double r,double ph){double X=r*cos(ph),Z=r*sin(ph);double w=(1-rim*r*r)*(1+g1*X+g2*Z);S.pad[s][n++]={aa*X+S.padc[s][0],aa*Z+S.padc[s][2],w};sum+=w;};
  double p0=U(0,1);put(0,0);for(int i=0;i<6;i++)put(0.43,p0+i*M_PI/3);for(int i=0;i<12;i++)put(0.83,p0+.2+i*M_PI/6);
  for(int i=0;i<NP;i++)S.pad[s][i].w/=sum;}
 // ---- conditions
 vector<double> speeds;double v0=U(.006,.012);int nsp=2+(in("viscous_friction")?1:RI(2));for(int i=0;i<nsp;i++)speeds.push_back(round(min(.03,v0*pow(U(1.6,2.4),i))*1e4)/1e4);
 vector<double> slopes={0};double sl=U(.1,.35);if(RI(4)||(S.kind==0&&nsp<3)||in("x_direction_sense")||in("anisotropic_friction")){slopes={-sl,0,sl};}
 vector<Cond> all,conds;
 if(S.kind!=4)for(double g:grips)for(double v:speeds){if(S.kind==2||S.kind==3){vector<double> os=S.kind==2?vector<double>{0,U(.001,.002),-U(.002,.003)}:vector<double>{0,U(.001,.003)};for(double o:os)all.push_back({0,g,v,slopes[RI(slopes.size())],round(o*1e4)/1e4});}
   else for(double s:slopes)all.push_back({0,g,v,s,0});}
 if(S.kind==1||S.kind==4){vector<double> om={U(.06,.12),U(.15,.3)};vector<double> of={0,round(U(.005,.02)*1e3)/1e3};for(double g:grips)for(double o:om)for(double f:of)all.push_back({1,g,round(o*1e4)/1e4,0,f});}
 int nrep=2+RI(2);shuffle(all.begin(),all.end(),rng);int want=12+RI(13);if(want*nrep>60)want=60/nrep;if(want*nrep<24)want=(24+nrep-1)/nrep;if((int)all.size()*nrep<24)nrep=3;
 // keep every grip level: greedy pick round-robin by grip
 while((int)conds.size()<want){bool any=false;for(double g:grips)for(size_t i=0;i<all.size()&&(int)conds.size()<want;i++)if(all[i].grip==g){conds.push_back(all[i]);all.erase(all.begin()+i);any=true;break;}if(!any)break;}
 vector<pair<int,int>> runs;for(size_t i=0;i<conds.size();i++)for(int r=0;r<nrep;r++)runs.push_back({(int)i,r});shuffle(runs.begin(),runs.end(),rng);
 mkdir(dir.c_str(),0755);mkdir((dir+"/trials").c_str(),0755);
 FILE*f=fopen((dir+"/dataset.toml").c_str(),"w");if(!f)return 1;
 fprintf(f,"format = \"stickslip-dataset/1\"\nname = \"bench %s\"\nsample_rate_hz = %.1f\ngravity_m_s2 = [0.0, 0.0, -9.81]\n\n[[objects]]\nid = \"bar\"\nshape = \"prism\"\nlength_m = %.6f\nside_m = %.6f\nmass_kg = %.6f\n\n[fingers]\ncontact = \"disc\"\ndiameter_m = %.6f\n",argv[1],S.rate,S.L,S.side,S.mass,S.dia);
 if(S.kind!=4){fprintf(f,"\n[pushers.linear_push]\n");if(S.kind==2)fprintf(f,"contact = \"point\"\ntip_radius_m = %.6f\n",S.tipr);else if(S.kind==3)fprintf(f,"contact = \"line\"\nlength_m = %.6f\n",S.linelen);else fprintf(f,"contact = \"plane\"\n");}
 if(S.kind==1||S.kind==4)fprintf(f,"\n[pushers.pivot]\ncontact = \"line\"\nlength_m = %.6f\n",S.linelen);
 fprintf(f,"\n[sensors.finger]\nforce_noise_n = %.5f\nforce_uncertainty_n = %.4f\ntorque_noise_nm = %.6f\ntorque_uncertainty_nm = %.5f\n\n[sensors.pusher]\nforce_noise_n = %.5f\nforce_uncertainty_n = %.4f\ntorque_noise_nm = %.6f\ntorque_uncertainty_nm = %.5f\n\n[sensors.pose]\nposition_noise_m = %.7f\nrotation_noise_rad = %.6f\n",S.ffn,S.ffu,S.ftn,S.ftu,S.pfn,S.pfu,S.ptn,S.ptu,S.posn,S.rotn);fclose(f);
 FILE*tf=fopen((dir+"/trials.csv").c_str(),"w");fprintf(tf,"trial,file,object,primitive,grip_n,speed_m_s,speed_rad_s,slope_rad,pusher_offset_m,run,pusher_x_m,pusher_y_m,pusher_z_m,pusher_qw,pusher_qx,pusher_qy,pusher_qz\n");
 // per-condition off-nominal stays none; trial by trial friction
 double fsd=U(.02,.03);int slid=0;double maxcreep=0;(void)maxcreep;
 uint64_t noiseSeed=rng();
 for(size_t n=0;n<runs.size();n++){const Cond&c=conds[runs[n].first];
  double common=1+clipn(fsd);double mf[2]={common*(1+clipn(.006)),common*(1+clipn(.006))},mp=1+clipn(fsd),pre[2]={clipn(.04),clipn(.04)};double rest0=U(.25,.4),gj=1+clipn(.002);
  if(only>=0&&(int)n!=only)continue;
  double es;auto smp=simulate(c,(int)n,dtf,mf,mp,pre,rest0,gj,es);
  if(es>(c.prim?0.0007:0.0015))slid++;
  mt19937_64 keep=rng;rng.seed(noiseSeed+n*7919);
  char nm[32];snprintf(nm,32,"t%04zu",n);V pn;if(c.prim==1)pn={-(S.L/2-0.006)+c.off,0,-S.side/2-.0003};else pn={-S.L/2-.0003-(S.kind==2?S.tipr:0),0,c.off};
  fprintf(tf,"%s,trials/%s.csv,bar,%s,%g,",nm,nm,c.prim?"pivot":"linear_push",c.grip);
  if(c.prim)fprintf(tf,",%g,,%g,",c.speed,c.off);else{fprintf(tf,"%g,,%.6g,",c.speed,c.slope);if(S.kind==2||S.kind==3)fprintf(tf,"%g",c.off);fprintf(tf,",");}
  fprintf(tf,"%d,%.7g,%.7g,%.7g,%s\n",runs[n].second,pn[0],pn[1],pn[2],c.prim?"0.7071067812,0,-0.7071067812,0":"1,0,0,0");
  FILE*o=fopen((dir+"/trials/"+nm+".csv").c_str(),"w");
  fprintf(o,"t_s,grip_cmd_n,gripper_x_m,gripper_y_m,gripper_z_m,gripper_qw,gripper_qx,gripper_qy,gripper_qz,object_x_m,object_y_m,object_z_m,object_qw,object_qx,object_qy,object_qz,finger1_fx_n,finger1_fy_n,finger1_fz_n,finger1_tx_nm,finger1_ty_nm,finger1_tz_nm,finger2_fx_n,finger2_fy_n,finger2_fz_n,finger2_tx_nm,finger2_ty_nm,finger2_tz_nm,pusher_fx_n,pusher_fy_n,pusher_fz_n,pusher_tx_nm,pusher_ty_nm,pusher_tz_nm\n");
  double lat=S.lat+e("mocap_latency","latency_s");double nz=nonoise?0:1;
  for(size_t k=0;k<smp.size();k++){auto&q=smp[k];
   double kk=max(0.0,k-lat*S.rate);size_t k0=(size_t)kk;double fr=kk-k0;size_t k1=min(k0+1,smp.size()-1);
   V op=(1-fr)*smp[k0].op+fr*smp[k1].op;M orr=smp[k0].orr;{M d=mm(smp[k1].orr,{{{orr[0][0],orr[1][0],orr[2][0]},{orr[0][1],orr[1][1],orr[2][1]},{orr[0][2],orr[1][2],orr[2][2]}}});V w={(d[2][1]-d[1][2])/2,(d[0][2]-d[2][0])/2,(d[1][0]-d[0][1])/2};orr=mm(rexp(fr*w),orr);}
   op=op+V{nz*S.posn*G1(),nz*S.posn*G1(),nz*S.posn*G1()};orr=mm(rexp({nz*S.rotn*G1(),nz*S.rotn*G1(),nz*S.rotn*G1()}),orr);
   auto qo=quat(orr),qg=quat(q.gr);
   fprintf(o,"%.6g,%g,%.7g,%.7g,%.7g,%.9g,%.9g,%.9g,%.9g,%.7g,%.7g,%.7g,%.9g,%.9g,%.9g,%.9g",q.t,q.grip,q.gp[0],q.gp[1],q.gp[2],qg[0],qg[1],qg[2],qg[3],op[0],op[1],op[2],qo[0],qo[1],qo[2],qo[3]);
   for(int s=0;s<2;s++){string fn="finger"+to_string(s+1);V mi=S.mis[s];const char*ax="xyz";for(int d=0;d<3;d++)mi[d]+=e("sensor_misalignment",(fn+"_"+ax[d]+"_rad").c_str());
    double gn=S.gain[s]*(1+e("sensor_gain",fn.c_str()));M Rm=rexp(mi);V F=gn*mul(Rm,q.f[s]),T=gn*mul(Rm,q.tq[s]);double fy=q.f[s][1];
    F[0]+=e("sensor_crosstalk",(fn+"_to_x").c_str())*fy;F[2]+=e("sensor_crosstalk",(fn+"_to_z").c_str())*fy;
    F=F+S.fb[s];T=T+S.tb[s];for(int d=0;d<3;d++){F[d]+=e("sensor_bias",(fn+"_f"+ax[d]+"_n").c_str());T[d]+=e("sensor_bias",(fn+"_t"+ax[d]+"_nm").c_str());}
    if(s==0&&has("x_temperature_drift")){double h=1-exp(-(double)n/E["x_temperature_drift"]["trials"]);F[0]+=h*E["x_temperature_drift"]["finger1_fx_n"];F[2]+=h*E["x_temperature_drift"]["finger1_fz_n"];}
    for(int d=0;d<3;d++)fprintf(o,",%.7g",F[d]+nz*S.ffn*G1());for(int d=0;d<3;d++)fprintf(o,",%.7g",T[d]+nz*S.ftn*G1());}
   {V mi=S.mispu;const char*ax="xyz";for(int d=0;d<3;d++)mi[d]+=e("sensor_misalignment",(string("pusher_")+ax[d]+"_rad").c_str());double gn=S.gainp*(1+e("sensor_gain","pusher"));M Rm=rexp(mi);V F=gn*mul(Rm,q.pf)+S.pb,T=gn*mul(Rm,q.pt)+S.ptb;
    for(int d=0;d<3;d++)fprintf(o,",%.7g",F[d]+nz*S.pfn*G1());for(int d=0;d<3;d++)fprintf(o,",%.7g",T[d]+nz*S.ptn*G1());}
   fprintf(o,"\n");}
  fclose(o);rng=keep;}
 fclose(tf);
 const char*kn[]={"plane","plane+line(pivot)","point","line","line(pivot)"};
 FILE*kf=fopen(argv[5],"w");fprintf(kf,"{\"number\": %s, \"seed\": %s, \"effects\": [",argv[1],argv[2]);bool fi=true;for(auto&id:ids){fprintf(kf,"%s{\"id\": \"%s\", \"params\": {",fi?"":", ",id.c_str());fi=false;bool f2=true;for(auto&p:E[id]){fprintf(kf,"%s\"%s\": %s",f2?"":", ",p.first.c_str(),js(p.second).c_str());f2=false;}fprintf(kf,"}}");}
 fprintf(kf,"], \"mu_finger\": %g, \"mu_pusher\": %g, \"pad_tangential_n_m\": %g, \"trials\": %zu, \"conditions\": %zu, \"pusher_kind\": \"%s\", \"pad_normal_n_m\": %g, \"pusher_n_m\": %g, \"pad_stiffening\": %g, \"grips_n\": [",S.muf,S.mup,S.K,runs.size(),conds.size(),kn[S.kind],S.K*S.knr,S.kp,S.stiffe);
 for(size_t i=0;i<grips.size();i++)fprintf(kf,"%s%g",i?", ":"",grips[i]);fprintf(kf,"], \"friction_run_sd\": %g, \"trials_slid\": %d, \"mass_kg\": %g, \"pad_creep\": %g, \"pause_s\": %g, \"mocap_base_latency_s\": %g}\n",fsd,slid,S.mass,S.creep,S.pausemax,S.lat);fclose(kf);
 fprintf(stderr,"%s kind=%s trials=%zu conds=%zu slid=%d steps=%ld it/step=%.2f fail=%ld K=%.3g muf=%.2f mup=%.2f\n",argv[1],kn[S.kind],runs.size(),conds.size(),slid,nstep,(double)niter/nstep,nfail,S.K,S.muf,S.mup);
 return 0;}
