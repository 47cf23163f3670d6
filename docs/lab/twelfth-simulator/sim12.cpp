// sim12: independent 'reality' of a prism between two soft fingertips, pushed against plate/edge. C++17.
// Pads: brush of viscoelastic (standard linear solid) bristles with local Coulomb sliders (closest-point return),
// two sliders of unlike friction at each place (Iwan-like spread), hardening normal law, crowned pads.
#include <cstdio>
#include <cstdlib>
#include <cmath>
#include <random>
#include <vector>
#include <array>
#include <string>
#include <map>
#include <algorithm>
#include <sys/stat.h>
using namespace std;
typedef double D;
struct V{D x=0,y=0,z=0;};
static inline V operator+(V a,V b){return{a.x+b.x,a.y+b.y,a.z+b.z};}
static inline V operator-(V a,V b){return{a.x-b.x,a.y-b.y,a.z-b.z};}
static inline V operator*(V a,D s){return{a.x*s,a.y*s,a.z*s};}
static inline D dot(V a,V b){return a.x*b.x+a.y*b.y+a.z*b.z;}
static inline V cross(V a,V b){return{a.y*b.z-a.z*b.y,a.z*b.x-a.x*b.z,a.x*b.y-a.y*b.x};}
static inline D nrm(V a){return sqrt(dot(a,a));}
struct M{D m[3][3];};
static inline V mul(const M&A,V v){return{A.m[0][0]*v.x+A.m[0][1]*v.y+A.m[0][2]*v.z,A.m[1][0]*v.x+A.m[1][1]*v.y+A.m[1][2]*v.z,A.m[2][0]*v.x+A.m[2][1]*v.y+A.m[2][2]*v.z};}
static inline V tmul(const M&A,V v){return{A.m[0][0]*v.x+A.m[1][0]*v.y+A.m[2][0]*v.z,A.m[0][1]*v.x+A.m[1][1]*v.y+A.m[2][1]*v.z,A.m[0][2]*v.x+A.m[1][2]*v.y+A.m[2][2]*v.z};}
struct Q{D w=1,x=0,y=0,z=0;};
static inline Q qm(Q a,Q b){return{a.w*b.w-a.x*b.x-a.y*b.y-a.z*b.z,a.w*b.x+a.x*b.w+a.y*b.z-a.z*b.y,a.w*b.y-a.x*b.z+a.y*b.w+a.z*b.x,a.w*b.z+a.x*b.y-a.y*b.x+a.z*b.w};}
static Q qrot(V r){D a=nrm(r);if(a<1e-14)return{1,r.x/2,r.y/2,r.z/2};D s=sin(a/2)/a;return{cos(a/2),r.x*s,r.y*s,r.z*s};}
static void qn(Q&q){D s=1/sqrt(q.w*q.w+q.x*q.x+q.y*q.y+q.z*q.z);q.w*=s;q.x*=s;q.y*=s;q.z*=s;}
static M mat(Q q){M A;D w=q.w,x=q.x,y=q.y,z=q.z;
 A.m[0][0]=1-2*(y*y+z*z);A.m[0][1]=2*(x*y-w*z);A.m[0][2]=2*(x*z+w*y);
 A.m[1][0]=2*(x*y+w*z);A.m[1][1]=1-2*(x*x+z*z);A.m[1][2]=2*(y*z-w*x);
 A.m[2][0]=2*(x*z-w*y);A.m[2][1]=2*(y*z+w*x);A.m[2][2]=1-2*(x*x+y*y);return A;}
typedef mt19937_64 R;
static D U(R&r,D a,D b){return uniform_real_distribution<D>(a,b)(r);}
static D LU(R&r,D a,D b){return exp(U(r,log(a),log(b)));}
static D N01(R&r){return normal_distribution<D>(0,1)(r);}
static D sg(R&r){return U(r,0,1)<.5?-1:1;}
typedef map<string,D> P; typedef map<string,P> E;
static const D PI=3.14159265358979;

struct Set{
 int number; uint64_t seed; E eff; string name;
 D L,s,mass,mass_stated; V com; V g;
 D a,a_true; D muf,mup; D kt,kn,nq,crown,stiff_exp,sls,sls_tau,spread; V padoff;
 D zt,zn; D tilt[2][2];
 D kp,kpt,zp; D yaw,pitch,lineyaw; D line_len;
 D rep_sc,rep_sc_p,grip_sc,jaw_tau; D ox;
 D noiseF,noiseT,noisePF,noisePT,npos,nrot; V bF[2],bT[2],bPF,bPT; D gain[3]; V mis[3]; D xt[3][2]; D driftF;
 V posbias,rotbias; D dt; D believed_f,believed_p;
 bool has(const char*e)const{return eff.count(e);}
 D p(const char*e,const char*k,D d=0)const{auto i=eff.find(e);if(i==eff.end())return d;auto j=i->second.find(k);return j==i->second.end()?d:j->second;}
};
struct Cond{string prim;D grip,v=NAN,w=NAN,slope=NAN,off=NAN;D rest,dist,tail;D grip2=0;int kind;};
struct Seg{D T,ta;D d[4];};
struct Trial{Cond c;int run,index;D muf,mup,gripf;V place;V placer;D gap;};
struct El{D x,z,w;D u[2][2],s[2][2];D th[2],vs[2];D h;};
struct PEl{D y,z,w;D u[2];};
struct Row{D t,cmd;V g;Q gq;V o;Q oq;V f[2],tq[2],pf,pt;};

static D trap(D t,D T,D ta){if(t<=0)return 0;if(t>=T)return 1;D v=1/(T-ta);if(t<ta)return v*t*t/2/ta;if(t>T-ta){D r=T-t;return 1-v*r*r/2/ta;}return v*(t-ta/2);}

static vector<Row> simulate(const Set&S,const Trial&T,D dt,V&pusher0,Q&pusherq){
 const Cond&c=T.c;bool piv=c.kind==1;
 // path
 vector<Seg> path;auto seg=[&](D dist,D v,D ux,D uy,D uz,D rot){D ta=0.06;D TT=dist/v+ta;Seg s{TT,ta,{ux*dist,uy*dist,uz*dist,rot*dist}};path.push_back(s);};
 auto hold=[&](D t){path.push_back({t,0.01,{0,0,0,0}});};
 hold(c.rest);D sl=isnan(c.slope)?0:c.slope;D cx=-cos(sl),cz=sin(sl);
 if(c.kind==0)seg(c.dist,c.v,cx,0,cz,0);
 if(c.kind==1)seg(c.dist,c.w,0,0,0,-1);
 if(c.kind==2){seg(c.dist*.6,c.v,cx,0,cz,0);seg(c.dist*.3,c.v,-cx,0,-cz,0);seg(c.dist*.6,c.v,cx,0,cz,0);}
 if(c.kind==3){seg(c.dist*.5,c.v,cx,0,cz,0);hold(0.8);seg(c.dist*.5,c.v,cx,0,cz,0);}
 if(c.kind==4){seg(c.dist*.4,c.v,-1,0,0,0);seg(c.dist*.35,c.v,-.8,.6,0,0);}
 if(c.kind==5)seg(c.dist,c.v,-1,0,0,0);
 hold(c.tail);D Ttot=0;for(auto&s:path)Ttot+=s.T;
 auto pose=[&](D t,D*o){o[0]=o[1]=o[2]=o[3]=0;for(auto&s:path){D f=trap(t,s.T,s.ta);for(int k=0;k<4;k++)o[k]+=s.d[k]*f;t-=s.T;if(t<=0)break;}};
 auto gripcmd=[&](D t){if(c.kind!=5)return c.grip;D tm=c.rest+.45*c.dist/c.v;D f=min(1.,max(0.,(t-tm)/.05));return c.grip+(c.grip2-c.grip)*f;};
 // true friction
 D base=T.muf*(1+S.p("wear_drift","rate_per_trial")*T.index);
 D mf[2]={base*(1+S.p("finger_friction_mismatch","mismatch")),base*(1-S.p("finger_friction_mismatch","mismatch"))};
 D lde=S.p("load_dependent_friction","exponent");
 D ss=S.p("static_friction","excess"),svs=S.p("static_friction","stribeck_speed_m_s",.002);
 D visc=S.p("viscous_friction","viscosity_s_m");
 bool dw=S.has("dwell_strengthening");D dwb=S.p("dwell_strengthening","strengthening"),dwc=S.p("dwell_strengthening","cutoff_s",.05),dwr=S.p("dwell_strengthening","renewal_m",2e-5);
 bool an=S.has("anisotropic_friction");D ar=S.p("anisotropic_friction","ratio",1);D ax=sqrt(ar),az=1/sqrt(ar);
 bool rate=ss!=0||visc!=0||dw;
 D slope=S.p("face_tilt","slope_rad"),fgrad=S.p("face_tilt","friction_gradient_1_m"),ggrad=S.p("face_tilt","grip_gradient_1_m");
 D wa=S.p("face_waviness","amplitude"),wl=S.p("face_waviness","wavelength_m",.008),wp=S.p("face_waviness","phase_rad");
 D adh=S.p("adhesion","pull_off_n");
 D lf=S.p("grip_force_loss","fraction"),lo=S.p("grip_force_loss","offset_n");
 D ldrop=S.p("grip_force_lag","drop"),ltime=S.p("grip_force_lag","time_s"),lknee=S.p("grip_force_lag","knee_m_s",1e-3),ld1=S.p("grip_force_lag","drop_1_m");
 D relA=S.p("unlisted:pad_stress_relaxation","share_after_3s");
 D armk=S.p("unlisted:arm_compliance","stiffness_n_m",0);
 V ext{S.p("external_force","x_n"),S.p("external_force","y_n"),S.p("external_force","z_n")};D extk=S.p("external_force","stiffness_n_m"),extx=S.p("external_force","at_x_m");
 V extdir=ext*(1/max(1e-9,nrm(ext)));
 // elements
 vector<El> el[2];D rr[3]={0,.5,.866};(void)rr;
 D d20=20/(S.kn*(1-S.nq/2)),A=(1-S.nq)*S.kn,B=S.nq*S.kn/2/d20;
 for(int f=0;f<2;f++){ // equal-area rings: 1+6+12 of 19
  D edges[4]={0,sqrt(1/19.),sqrt(7/19.),1};int cnt[3]={1,6,12};
  for(int r=0;r<3;r++){D ri=edges[r],ro=edges[r+1];D rm=r==0?0:sqrt((ri*ri+ro*ro)/2);
   if(r>0)rm=2./3*(ro*ro*ro-ri*ri*ri)/(ro*ro-ri*ri);
   for(int k=0;k<cnt[r];k++){El e{};D ph=2*PI*(k+.5*(r%2))/cnt[r];D x=rm*cos(ph)*S.a_true,z=rm*sin(ph)*S.a_true;
    e.x=x+S.padoff.x;e.z=z+S.padoff.z;e.w=1./19;e.h=S.crown*d20*(rm*rm)+S.tilt[f][0]*d20*x/S.a_true+S.tilt[f][1]*d20*z/S.a_true;
    for(int q=0;q<2;q++){e.th[q]=1e-3;}el[f].push_back(e);}}}
 // pusher
 V P0;Q pq;
 if(!piv){P0={S.ox-S.L/2-T.gap,0,0};pq={1,0,0,0};}
 else{P0={S.ox-S.L/2+.005+c.off,0,-S.s/2-T.gap};pq={sqrt(.5),0,-sqrt(.5),0};}
 pusher0=P0;pusherq=pq;
 Q pqt=qm(pq,qm(qrot({0,0,piv?S.lineyaw:S.yaw}),qrot({0,piv?0:S.pitch,0})));M Rp=mat(pqt);
 V pn=mul(Rp,{1,0,0}),p1=mul(Rp,{0,1,0}),p2=mul(Rp,{0,0,1});
 vector<PEl> pe;
 if(!piv){for(int i=0;i<5;i++)for(int j=0;j<5;j++){D w=(i%4?1:.5)*(j%4?1:.5)/16;pe.push_back({(i-2)*S.s/4,(j-2)*S.s/4,w,{0,0}});}}
 else{D h=min(S.s,S.line_len)/2;for(int i=0;i<7;i++){D w=(i%6?1:.5)/6;pe.push_back({(i-3)*h/3,0,w,{0,0}});}}
 D m=S.mass;V I{m*S.s*S.s/6,m*(S.L*S.L+S.s*S.s)/12,m*(S.L*S.L+S.s*S.s)/12};
 D cn=2*S.zn*sqrt(S.kn*m/2);            // per finger, proportional
 D bt=2*S.zt/sqrt(2*S.kt/m);            // tangential damping time
 D bp=2*S.zp/sqrt(S.kp/m);              // pusher damping time
 // state
 Q q=qrot(T.placer);M Ro=mat(q);V pO=V{S.ox,0,0}+T.place;V pc=pO+mul(Ro,S.com);V v{},w{};
 D gap;{// jaw gap for grip
  D target=gripcmd(-1);D lo_=S.s/2-20*d20-1e-3,hi=S.s/2+1e-3;for(int it=0;it<80;it++){gap=(lo_+hi)/2;D F=0;for(auto&e:el[0]){D d=S.s/2-gap-e.h;if(d>0)F+=e.w*(A*d+B*d*d);}if(F>target)lo_=gap;else hi=gap;}}
 D dropst=0,gfil=0,slipd=0;V arm{},armv{};bool first=true;D cx0=0;
 D pre=0.3;long n0=lround(pre/dt),n=lround(Ttot/dt);int every=lround(.004/dt);int navg=max(1,(int)lround(.001/dt));
 int hev=lround(.001/dt);
 vector<Row> rows;vector<pair<V,Q>> hist;vector<D> ht;
 V aF[2],aT[2],aPF,aPT;int na=0;
 D lat=S.p("mocap_latency","latency_s");
 D gp[4],gp1[4];pose(0,gp);D angk=0;
 D fac_x0=0;bool havex0=false;
 for(long k=-n0;k<=n;k++){
  D t=k*dt;
  pose(max(0.,t),gp);pose(max(0.,t+dt),gp1);
  V gpos{gp[0],gp[1],gp[2]};V gv{(gp1[0]-gp[0])/dt,(gp1[1]-gp[1])/dt,(gp1[2]-gp[2])/dt};D gw=(gp1[3]-gp[3])/dt;
  V gtrue=gpos+arm;
  Q gq=qrot({0,gp[3],0});M Rg=mat(gq);
  Ro=mat(q);V ex=mul(Ro,{1,0,0}),ey=mul(Ro,{0,1,0});
  pO=pc-mul(Ro,S.com);
  V c_=tmul(Rg,pO-gtrue);
    V Vr=tmul(Rg,v+cross(w,gtrue-pc)-gv-armv),Wr=tmul(Rg,w-V{0,gw,0});
  V oxg=tmul(Rg,ex),oyg=tmul(Rg,ey);
  D xpad=-dot(c_,oxg); // pad centre along object X
  if(!havex0&&k>=0){fac_x0=xpad;havex0=true;}
  if(first){cx0=xpad;first=false;}
  V F{},Tq{};V ff[2],tt[2];D Nf[2];D slipsp=0;
  V fsum{};
  for(int f=0;f<2;f++){
   D sgn=f==0?1:-1;
   // face normal (outward) in gripper axes, wedge: face rises towards object +X
   V nf=oyg*sgn+oxg*(-slope);D inv=1/nrm(nf);nf=nf*inv;
   // plane: dot(nf, rho - c_) = s/2
   D muN;V fs{},ts{};D Nsum=0;
   D loc=mf[f]*(1+fgrad*(xpad))*(1+wa*sin(2*PI*xpad/wl+wp));
   static D fn[2][32];
   V cp{0,c_.y+sgn*S.s/2,0};
   for(size_t i=0;i<el[f].size();i++){El&e=el[f][i];
    D yf=c_.y+(S.s/2-nf.x*(e.x-c_.x)-nf.z*(e.z-c_.z))/nf.y;
    D ypad=sgn*(gap+e.h+slope*(e.x+cx0)); // pads were set up flush on the wedge
    D del=sgn*(yf-ypad);
    V ve=Vr+cross(Wr,{e.x,yf,e.z});
    D vn=dot(ve,nf);
    D fi=0;if(del>0){fi=e.w*(A*del+B*del*del+cn*vn);if(fi<0)fi=0;}
    fn[f][i]=fi;Nsum+=fi;}
   Nf[f]=Nsum;
   D mu=loc;if(lde!=0)mu*=pow(max(.5,Nsum)/25,-lde);
   D kfac=pow(max(1.,Nsum)/25,S.stiff_exp);
   D kk=S.kt*kfac/19/2;D kinf=kk*(1-S.sls),k1=kk*S.sls,cd=kk*bt,ktot=kinf+k1+cd/dt;
   D so=oxg.x,co_z=oxg.z; // object X direction in gripper xz-plane
   for(size_t i=0;i<el[f].size();i++){El&e=el[f][i];D fi=fn[f][i];
    D yf=cp.y;V r{e.x,yf,e.z};
    V ve=Vr+cross(Wr,r);D vx=ve.x-dot(ve,nf)*nf.x,vz=ve.z-dot(ve,nf)*nf.z;
    D tx=0,tz=0;
    for(int s2=0;s2<2;s2++){
     D*u=e.u[s2],*s=e.s[s2];
     D mm=mu*(s2?1+S.spread:1-S.spread);
     if(rate){D sv=e.vs[s2];mm*=1+ss*exp(-sv/svs);mm+=visc*sv*(s2?1+S.spread:1-S.spread);if(dw)mm*=1+dwb*log(1+e.th[s2]/dwc);}
     D lim=mm*(fi+adh*e.w)/2;
     D hx=k1*s[0]+cd/dt*u[0],hz=k1*s[1]+cd/dt*u[1];
     D fx=ktot*(u[0]+vx*dt)-hx,fz=ktot*(u[1]+vz*dt)-hz;
     D slip=0;
     if(!an){D mg=fx*fx+fz*fz;
      if(mg>lim*lim){D r0=lim/sqrt(mg);slip=(1-r0)*sqrt(mg)/ktot/dt;fx*=r0;fz*=r0;}
     }else{ // ellipse in object axes, associated flow
      D a_=fx*so+fz*co_z,b_=-fx*co_z+fz*so;D ex_=lim*ax,ez_=lim*az;
      if(lim<1e-9){fx=fz=0;}
      else if(a_*a_/(ex_*ex_)+b_*b_/(ez_*ez_)>1){D lam=0;D X=ex_*ex_,Z=ez_*ez_;
       for(int it=0;it<12;it++){D pa=a_/(1+lam/X),pb=b_/(1+lam/Z);D h=pa*pa/X+pb*pb/Z-1;if(fabs(h)<1e-10)break;D dh=-2*pa*pa/X/(X+lam)-2*pb*pb/Z/(Z+lam);lam-=h/dh;if(lam<0)lam=0;}
       D pa=a_/(1+lam/X),pb=b_/(1+lam/Z);D h=sqrt(pa*pa/X+pb*pb/Z);pa/=h;pb/=h;fx=pa*so-pb*co_z;fz=pa*co_z+pb*so;}
     }
     u[0]=(fx+hx)/ktot;u[1]=(fz+hz)/ktot;
     s[0]+=(u[0]-s[0])*dt/S.sls_tau;s[1]+=(u[1]-s[1])*dt/S.sls_tau;
     if(rate){e.vs[s2]+=(slip-e.vs[s2])*min(1.,dt/1e-3);if(dw){e.th[s2]+=(1-e.th[s2]*e.vs[s2]/dwr)*dt;if(e.th[s2]<0)e.th[s2]=0;}}
     tx-=fx;tz-=fz;}
    V tf{tx,-(nf.x*tx+nf.z*tz)/nf.y,tz};
    V fo=tf-nf*fi;fs=fs+fo;ts=ts+cross(V{e.x-cp.x,0,e.z-cp.z},fo);}
   ff[f]=fs;tt[f]=ts;
   V fw=mul(Rg,fs);F=F+fw;V rc=gtrue+mul(Rg,cp)-pc;Tq=Tq+mul(Rg,ts)+cross(rc,fw);
   V vc=Vr+cross(Wr,cp);slipsp+=.5*sqrt(vc.x*vc.x+vc.z*vc.z+ .25*Wr.y*Wr.y*S.a*S.a);
   fsum=fsum+fw;
  }
  // pusher
  V pf{},pt{};
  for(auto&e:pe){
   V r;D pen;V nn,t1,t2;
   if(!piv){r=pO+mul(Ro,{-S.L/2,e.y,e.z});pen=-dot(pn,r-P0);nn=pn;t1=p1;t2=p2;}
   else{r=P0+p1*e.y;V z=tmul(Ro,r-pO);pen=z.z+S.s/2;nn=mul(Ro,{0,0,1});t1=ex;t2=ey;if(fabs(z.x)>S.L/2||pen>.003)pen=-1;}
   if(pen<=0){e.u[0]=e.u[1]=0;continue;}
   V vr=v+cross(w,r-pc);
   D fi=e.w*S.kp*(pen-bp*dot(vr,nn));if(fi<0)fi=0;
   D kk=e.w*S.kpt,cd=kk*bp,kt=kk+cd/dt;
   D h0=cd/dt*e.u[0],h1=cd/dt*e.u[1];
   D f0=kt*(e.u[0]+dot(vr,t1)*dt)-h0,f1=kt*(e.u[1]+dot(vr,t2)*dt)-h1;
   D mg=sqrt(f0*f0+f1*f1),lim=T.mup*fi;if(mg>lim){f0*=lim/mg;f1*=lim/mg;}
   e.u[0]=(f0+h0)/kt;e.u[1]=(f1+h1)/kt;
   V fo=nn*fi-t1*f0-t2*f1;pf=pf+fo;pt=pt+cross(r-P0,fo);}
  F=F+pf;Tq=Tq+pt+cross(P0-pc,pf);
  // gravity, external
  D ramp=min(1.,(t+pre)/.1);V fg=S.g*(m*ramp);F=F+fg;
  if(S.has("external_force")){V fe=ext;if(k>=0){D along=dot(pO-(V{S.ox,0,0}+T.place),extdir);fe=fe-extdir*(extk*along);}fe=fe*ramp;F=F+fe;Tq=Tq+cross(pO+mul(Ro,{extx,0,0})-pc,fe);}
  if(t<-.12){F=F-v*(m*60);Tq=Tq-mul(Ro,[&]{V wb=tmul(Ro,w);return V{wb.x*I.x,wb.y*I.y,wb.z*I.z};}())*60;}
  // record
  if(k>=0){int ph=k%every;if(k==0||ph==0||ph>every-navg){for(int f=0;f<2;f++){aF[f]=aF[f]+ff[f];aT[f]=aT[f]+tt[f];}aPF=aPF+pf;aPT=aPT+pt;na++;}
   if(ph==0){Row r;r.t=t;r.cmd=gripcmd(t);r.g=gpos;r.gq=gq;r.o=pO;r.oq=q;for(int f=0;f<2;f++){r.f[f]=aF[f]*(1./na);r.tq[f]=aT[f]*(1./na);aF[f]=aT[f]=V{};}r.pf=aPF*(1./na);r.pt=aPT*(1./na);aPF=aPT=V{};na=0;rows.push_back(r);}}
  if((k+n0)%hev==0){hist.push_back({pO,q});ht.push_back(t);}
  // grip control
  D cmd=gripcmd(t);D tar=cmd*T.gripf*(1-lf)-lo;
  if(k>=0){
   if(S.has("grip_force_lag")){slipd+=(slipsp>lknee*.2?slipsp:0)*dt;D want=ldrop*slipsp/(slipsp+lknee);dropst+=(want-dropst)*dt/max(ltime,dt);if(gfil==0)gfil=tar;gfil+=(tar-gfil)*dt/max(ltime,dt);tar=gfil*(1-dropst-ld1*slipd);}
   tar*=1+ggrad*(xpad-fac_x0);
   if(relA!=0)tar*=1-relA*log(1+t/.3)/log(11.);}
  D N=.5*(Nf[0]+Nf[1]);gap-=(tar-N)/(S.kn*S.jaw_tau)*dt;
  if(armk>0&&k>-n0+1){V want=fsum*(-1/armk);armv=(want-arm)*(1/.008);arm=arm+armv*dt;}
  // integrate
  v=v+F*(dt/m);V wb=tmul(Ro,w),tb=tmul(Ro,Tq);V Iw{wb.x*I.x,wb.y*I.y,wb.z*I.z};V ac=tb-cross(wb,Iw);
  w=w+mul(Ro,{ac.x/I.x,ac.y/I.y,ac.z/I.z})*dt;
  pc=pc+v*dt;q=qm(qrot(w*dt),q);if((k&63)==0)qn(q);
 }
 if(lat!=0)for(auto&r:rows){D tt=r.t-lat;D x=(tt-ht[0])/(ht[1]-ht[0]);int i=max(0,min((int)ht.size()-2,(int)floor(x)));D f=min(1.,max(0.,x-i));V a=hist[i].first,b=hist[i+1].first;r.o=a+(b-a)*f;Q qa=hist[i].second,qb=hist[i+1].second;r.oq={qa.w+(qb.w-qa.w)*f,qa.x+(qb.x-qa.x)*f,qa.y+(qb.y-qa.y)*f,qa.z+(qb.z-qa.z)*f};qn(r.oq);}
 return rows;
}
static D qz(D v,D step){return step*round(v/step);}

static void drawEffects(Set&S,const vector<string>&ids,R&r){
 auto sc=[&]{return U(r,.7,1.8);};
 for(auto id:ids){P p;
  if(id=="static_friction"){p["excess"]=U(r,.15,.35);p["stribeck_speed_m_s"]=U(r,.001,.004);}
  else if(id=="viscous_friction")p["viscosity_s_m"]=U(r,3,8);
  else if(id=="dwell_strengthening"){p["strengthening"]=U(r,.04,.1);p["cutoff_s"]=U(r,.03,.1);p["renewal_m"]=U(r,1e-5,4e-5);}
  else if(id=="load_dependent_friction")p["exponent"]=U(r,.15,.33);
  else if(id=="anisotropic_friction"){D a=U(r,1.3,1.7);p["ratio"]=sg(r)>0?a:1/a;}
  else if(id=="finger_friction_mismatch")p["mismatch"]=sg(r)*U(r,.1,.25);
  else if(id=="wear_drift")p["rate_per_trial"]=-U(r,.004,.01);
  else if(id=="torsional_friction")p["radius_change_m"]=sg(r)*U(r,.0013,.0025);
  else if(id=="pressure_offset"){p["offset_x_m"]=sg(r)*.002*sc();p["offset_z_m"]=sg(r)*.001*sc();}
  else if(id=="face_tilt"){p["slope_rad"]=sg(r)*U(r,.012,.022);}
  else if(id=="face_waviness"){p["amplitude"]=U(r,.08,.18);p["wavelength_m"]=U(r,.004,.009);p["phase_rad"]=U(r,-3.1,3.1);}
  else if(id=="plate_tilt"){p["yaw_rad"]=sg(r)*U(r,.007,.02);p["pitch_rad"]=sg(r)*U(r,.007,.02);}
  else if(id=="adhesion")p["pull_off_n"]=U(r,1,2.2);
  else if(id=="grip_force_loss"){p["fraction"]=U(r,.07,.18);}
  else if(id=="grip_force_lag"){p["drop"]=U(r,.1,.24);p["time_s"]=U(r,.06,.2);p["knee_m_s"]=U(r,.0007,.002);}
  else if(id=="mass_error"){p["fraction"]=sg(r)*U(r,.08,.2);p["com_x_m"]=sg(r)*U(r,.003,.007);}
  else if(id=="external_force"){p["x_n"]=sg(r)*.5*sc();p["y_n"]=sg(r)*.5*sc();p["z_n"]=sg(r)*.5*sc();p["stiffness_n_m"]=20*sc();p["at_x_m"]=0;}
  else if(id=="gravity_tilt"){p["about_x_rad"]=sg(r)*.06*sc();p["about_y_rad"]=sg(r)*.06*sc();}
  else if(id=="sensor_gain"){p["pusher"]=sg(r)*.05*sc();p["finger1"]=sg(r)*.05*sc();}
  else if(id=="sensor_misalignment"){p["finger1_x_rad"]=sg(r)*.03*sc();p["finger2_z_rad"]=sg(r)*.03*sc();}
  else if(id=="mocap_latency")p["latency_s"]=.02*sc();
  else if(id=="unlisted:arm_compliance")p["stiffness_n_m"]=LU(r,2.5e4,7e4);
  else if(id=="unlisted:force_lowpass"){p["cutoff_hz"]=U(r,3,6);p["order"]=2;}
  else if(id=="unlisted:sensor_zero_drift"){p["finger1_x_n_first_to_last"]=sg(r)*U(r,.5,1);p["finger2_z_n_first_to_last"]=sg(r)*U(r,.5,1);p["pusher_x_n_first_to_last"]=sg(r)*U(r,.5,1.2);}
  else if(id=="unlisted:pad_stress_relaxation")p["share_after_3s"]=U(r,.1,.22);
  else if(id!="none"){fprintf(stderr,"unknown %s\n",id.c_str());exit(1);}
  if(id!="none")S.eff[id]=p;}
}
int main(int argc,char**argv){
 if(argc<5){fprintf(stderr,"sim12 OUT NUMBER SEED EFFECTS[,..] [conv]\n");return 1;}
 string out=argv[1];Set S;S.number=atoi(argv[2]);S.seed=strtoull(argv[3],0,10);R r(S.seed);
 vector<string> ids;{string a=argv[4],b;for(char ch:a+","){if(ch==','){ids.push_back(b);b="";}else b+=ch;}}
 bool conv=argc>5;
 R re(S.seed*7919+13);drawEffects(S,ids,re);
 D L=U(r,.085,.15),s=U(r,.02,.036);S.L=round(L*1e3)/1e3;S.s=round(s*2e3)/2e3;D rho=U(r,0,1)<.5?U(r,1050,1400):U(r,2600,2800);
 S.mass_stated=round(S.L*S.s*S.s*rho*1e4)/1e4;S.mass_stated=min(.35,max(.06,S.mass_stated));
 S.mass=S.mass_stated*(1+S.p("mass_error","fraction"))*(1+.003*N01(r));S.com={S.p("mass_error","com_x_m")+.0001*N01(r),0,0};
 {M a=mat(qm(qrot({S.p("gravity_tilt","about_x_rad")+.001*N01(r),0,0}),qrot({0,S.p("gravity_tilt","about_y_rad")+.001*N01(r),0})));S.g=mul(a,{0,0,-9.81});}
 S.a=round(U(r,.007,min(.011,S.s/2-.0005))*2000)/2000;S.a_true=S.a+1.5*S.p("torsional_friction","radius_change_m");
 S.padoff={S.p("pressure_offset","offset_x_m"),0,S.p("pressure_offset","offset_z_m")};
 S.muf=U(r,.2,.9);S.mup=U(r,.15,.8);S.kt=LU(r,8e3,1.5e6);S.kn=min(4e6,S.kt*LU(r,1.5,5));
 S.nq=U(r,0,.6);S.crown=U(r,.05,.35);S.stiff_exp=U(r,0,.33);S.sls=U(r,.03,.25);S.sls_tau=LU(r,.05,1);S.spread=U(r,0,.3);
 S.zt=U(r,.08,.25);S.zn=U(r,.08,.25);S.zp=U(r,.05,.2);
 for(int f=0;f<2;f++)for(int k=0;k<2;k++)S.tilt[f][k]=.04*N01(r);
 S.kp=LU(r,3e5,4e6);S.kpt=S.kp*U(r,.4,.9);
 S.yaw=U(r,-.0008,.0008);S.pitch=U(r,-.0008,.0008);S.lineyaw=U(r,-.0008,.0008);
 if(S.has("plate_tilt")){S.yaw+=S.p("plate_tilt","yaw_rad");S.pitch+=S.p("plate_tilt","pitch_rad");}
 S.line_len=round(S.s*1.1*1e3)/1e3;
 S.rep_sc=U(r,.005,.025);S.rep_sc_p=U(r,.005,.025);S.grip_sc=U(r,.001,.006);S.jaw_tau=LU(r,.004,.015);
 S.ox=round(U(r,-.005,.005)*1e4)/1e4;
 S.noiseF=LU(r,.01,.04);S.noiseT=LU(r,.0002,.0006);S.noisePF=LU(r,.02,.06);S.noisePT=LU(r,.0008,.003);S.npos=LU(r,1.5e-5,6e-5);S.nrot=LU(r,1e-4,5e-4);
 auto nv=[&](D a){return V{a*N01(r),a*N01(r),a*N01(r)};};
 for(int f=0;f<2;f++){S.bF[f]=nv(.03);S.bT[f]=nv(.0003);}S.bPF=nv(.05);S.bPT=nv(.002);
 for(int k=0;k<3;k++){S.gain[k]=.003*N01(r);S.mis[k]=nv(.0015);S.xt[k][0]=.0015*N01(r);S.xt[k][1]=.0015*N01(r);}
 S.driftF=U(r,.005,.03);S.posbias=nv(3e-5);S.rotbias=nv(2e-4);
 S.believed_f=S.muf*(1+U(r,-.15,.15));S.believed_p=S.mup*(1+U(r,-.15,.15));
 S.dt=1e-5;
 // grips
 D mg=S.mass*9.81*1.3;D muw=S.muf*.7;D gmin=max(8.,max(3*mg/(2*muw),4*mg*(fabs(S.ox)+fabs(S.com.x))/(4./3*muw*S.a)));gmin=min(gmin,24.);
 D g1=round(U(r,gmin,gmin+5)),g3=round(U(r,max(g1+8,26.),40));D g2=round((g1+g3)/2);D grips[3]={g1,g2,g3};
 D v1=U(r,.005,.009),v3=U(r,.018,.03);v1=round(v1*1e3)/1e3;v3=round(v3*1e3)/1e3;D sp[3]={v1,round((v1+v3)/2*1e3)/1e3,v3};
 D slp[5]={-.349066,-.174533,0,.174533,.349066};
 int nc=12+(int)(U(r,0,7)*.9999);int npiv=2+(int)U(r,0,3.999);int nrev=1+(int)U(r,0,1.999),npau=1,nside=(U(r,0,1)<.5)&&S.mup<.4,nreg=U(r,0,1)<.35;
 if(S.has("dwell_strengthening"))npau=2;if(S.has("grip_force_lag"))nreg=1;
 int nlin=nc-npiv-nrev-npau-nside-nreg;
 D soft=min(.006,2*.5*30/(2*S.kt)); // pads' give
 vector<Cond> cs;D tail=U(r,.15,.35);D rest0=U(r,.3,.5);
 auto add=[&](int kind,const char*prim,D grip,D v,D slope){Cond c;c.kind=kind;c.prim=prim;c.grip=grip;c.v=v;c.slope=slope;c.rest=rest0;c.tail=tail;c.dist=min(.014,max(.006+soft,v*1.6));if(kind>=2)c.dist=max(c.dist,.009+soft);cs.push_back(c);};
 // linear: distinct combinations
 {vector<array<int,3>> all;for(int a=0;a<3;a++)for(int b=0;b<3;b++)for(int k=0;k<5;k++)all.push_back({a,b,k});shuffle(all.begin(),all.end(),r);
  // make sure of straight pushes at extremes of grip and speed
  vector<array<int,3>> ch={{0,2,2},{2,0,2},{2,2,2}};for(auto&x:all){if((int)ch.size()>=nlin)break;if(find(ch.begin(),ch.end(),x)==ch.end())ch.push_back(x);}
  ch.resize(nlin);for(auto&x:ch)add(0,"linear_push",grips[x[0]],sp[x[1]],slp[x[2]]);}
 for(int i=0;i<npiv;i++){Cond c;c.kind=1;c.prim="pivot";c.grip=grips[i%3];D wv[3]={.1,.2,.35};c.w=wv[(i*2+1)%3];c.off=i%2?.012:0;c.rest=rest0;c.tail=tail;c.dist=U(r,.18,.35);if(c.w<.15)c.dist=min(c.dist,.2);cs.push_back(c);}
 for(int i=0;i<nrev;i++)add(2,"push_reverse",grips[i?2:0],sp[1+i%2],0);
 for(int i=0;i<npau;i++)add(3,"push_pause",grips[1],sp[i?2:1],0);
 for(int i=0;i<nside;i++)add(4,"push_side",grips[1],sp[1],NAN);
 for(int i=0;i<nreg;i++){add(5,"push_regrip",grips[2],sp[1],0);cs.back().grip2=grips[1];}
 if(S.has("dwell_strengthening"))for(auto&c:cs)if(c.kind==0)c.rest=U(r,0,1)<.5?rest0:rest0+1.;
 vector<Trial> ts;
 for(int rep=0;rep<2;rep++){vector<int> o(nc);for(int i=0;i<nc;i++)o[i]=i;shuffle(o.begin(),o.end(),r);
  for(int i:o){Trial t;t.c=cs[i];t.run=rep;t.index=ts.size();t.muf=S.muf*exp(S.rep_sc*N01(r));t.mup=S.mup*exp(S.rep_sc_p*N01(r));t.gripf=1+S.grip_sc*N01(r);
   t.place={1e-4*N01(r),0,1e-4*N01(r)};t.placer={2e-4*N01(r),6e-4*N01(r),2e-4*N01(r)};t.gap=U(r,.0006,.0012);ts.push_back(t);}}
 if(conv){V p0;Q pq;int done=0;for(auto&T:ts){if(done==0&&T.c.kind!=0)continue;if(done==1&&T.c.kind!=1)continue;if(done==2&&T.c.kind!=2)continue;if(done>2)break;
   auto a=simulate(S,T,S.dt,p0,pq),b=simulate(S,T,S.dt/2,p0,pq);D mx[6]={0},rm[6]={0},pk=0;
   for(size_t i=0;i<a.size()&&i<b.size();i++){D d[6]={nrm(a[i].f[0]-b[i].f[0]),nrm(a[i].f[1]-b[i].f[1]),nrm(a[i].pf-b[i].pf),nrm(a[i].tq[0]-b[i].tq[0]),nrm(a[i].o-b[i].o),2*sqrt(pow(a[i].oq.x-b[i].oq.x,2)+pow(a[i].oq.y-b[i].oq.y,2)+pow(a[i].oq.z-b[i].oq.z,2))};for(int k=0;k<6;k++){mx[k]=max(mx[k],d[k]);rm[k]+=d[k]*d[k]/a.size();}pk=max(pk,nrm(a[i].pf));}
   printf("%s dt=%g kt=%.3g peak pusher %.3g N: max/rms diff f1 %.3g/%.3g N f2 %.3g/%.3g pusher %.3g/%.3g N t1 %.3g/%.3g Nm pos %.3g/%.3g m rot %.3g/%.3g\n",T.c.prim.c_str(),S.dt,S.kt,pk,mx[0],sqrt(rm[0]),mx[1],sqrt(rm[1]),mx[2],sqrt(rm[2]),mx[3],sqrt(rm[3]),mx[4],sqrt(rm[4]),mx[5],sqrt(rm[5]));done++;}
  return 0;}
 string dir=out+"/"+argv[2];mkdir(dir.c_str(),0755);mkdir((dir+"/trials").c_str(),0755);
 FILE*f=fopen((dir+"/dataset.toml").c_str(),"w");
 fprintf(f,"format = \"stickslip-dataset/1\"\nname = \"bench %d\"\nsample_rate_hz = 250.0\ngravity_m_s2 = [0.0, 0.0, -9.81]\n\n[[objects]]\nid = \"block\"\nshape = \"prism\"\nlength_m = %g\nside_m = %g\nmass_kg = %g\n\n[fingers]\ncontact = \"disc\"\ndiameter_m = %g\nfriction_believed = %.3f\n",S.number,S.L,S.s,S.mass_stated,2*S.a,S.believed_f);
 vector<string> prims;for(auto&c:cs)if(find(prims.begin(),prims.end(),c.prim)==prims.end())prims.push_back(c.prim);
 for(auto&p:prims){if(p=="pivot")fprintf(f,"\n[pushers.pivot]\ncontact = \"line\"\nlength_m = %g\nfriction_believed = %.3f\n",S.line_len,S.believed_p);else fprintf(f,"\n[pushers.%s]\ncontact = \"plane\"\nfriction_believed = %.3f\n",p.c_str(),S.believed_p);}
 fprintf(f,"\n[sensors.finger]\nforce_noise_n = %.3g\nforce_uncertainty_n = 0.25\ntorque_noise_nm = %.3g\ntorque_uncertainty_nm = 0.003\n\n[sensors.pusher]\nforce_noise_n = %.3g\nforce_uncertainty_n = 0.5\ntorque_noise_nm = %.3g\ntorque_uncertainty_nm = 0.02\n\n[sensors.pose]\nposition_noise_m = %.3g\nrotation_noise_rad = %.3g\n",S.noiseF,S.noiseT,S.noisePF,S.noisePT,S.npos,S.nrot);fclose(f);
 FILE*tc=fopen((dir+"/trials.csv").c_str(),"w");fprintf(tc,"trial,file,object,primitive,grip_n,speed_m_s,speed_rad_s,slope_rad,pusher_offset_m,run,pusher_x_m,pusher_y_m,pusher_z_m,pusher_qw,pusher_qx,pusher_qy,pusher_qz\n");
 auto num=[&](D x){char b[40];if(isnan(x))return string();snprintf(b,40,"%.6g",x);return string(b);};
 // sensor state that lives through the session
 V dF[2],dPF;
 for(auto&T:ts){V p0;Q pq;auto rows=simulate(S,T,S.dt,p0,pq);R rn(S.seed*1000003+T.index);
  char id[16];snprintf(id,16,"t%04d",T.index);const Cond&c=T.c;
  fprintf(tc,"%s,trials/%s.csv,block,%s,%g,%s,%s,%s,%s,%d,%.6f,%.6f,%.6f,%.9g,%.9g,%.9g,%.9g\n",id,id,c.prim.c_str(),c.grip,num(c.v).c_str(),num(c.w).c_str(),num(c.slope).c_str(),num(c.off).c_str(),T.run,p0.x,p0.y,p0.z,pq.w,pq.x,pq.y,pq.z);
  FILE*g=fopen((dir+"/trials/"+id+".csv").c_str(),"w");
  fprintf(g,"t_s,grip_cmd_n,gripper_x_m,gripper_y_m,gripper_z_m,gripper_qw,gripper_qx,gripper_qy,gripper_qz,object_x_m,object_y_m,object_z_m,object_qw,object_qx,object_qy,object_qz,finger1_fx_n,finger1_fy_n,finger1_fz_n,finger1_tx_nm,finger1_ty_nm,finger1_tz_nm,finger2_fx_n,finger2_fy_n,finger2_fz_n,finger2_tx_nm,finger2_ty_nm,finger2_tz_nm,pusher_fx_n,pusher_fy_n,pusher_fz_n,pusher_tx_nm,pusher_ty_nm,pusher_tz_nm\n");
  // unlisted low-pass
  D fc=S.p("unlisted:force_lowpass","cutoff_hz");
  if(fc>0){D al=1-exp(-2*PI*fc*.004);for(int pass=0;pass<2;pass++){Row st=rows[0];for(auto&x:rows){for(int k=0;k<2;k++){st.f[k]=st.f[k]+(x.f[k]-st.f[k])*al;st.tq[k]=st.tq[k]+(x.tq[k]-st.tq[k])*al;x.f[k]=st.f[k];x.tq[k]=st.tq[k];}st.pf=st.pf+(x.pf-st.pf)*al;st.pt=st.pt+(x.pt-st.pt)*al;x.pf=st.pf;x.pt=st.pt;}}}
  D prog=(D)T.index/max(1,(int)ts.size()-1);
  for(int k=0;k<2;k++)dF[k]=dF[k]*.8+V{N01(rn),N01(rn),N01(rn)}*(S.driftF*.5);dPF=dPF*.8+V{N01(rn),N01(rn),N01(rn)}*S.driftF;
  for(auto&x:rows){
   auto N3=[&](D a){D p=N01(rn),q2=N01(rn),r2=N01(rn);return V{a*p,a*q2,a*r2};};
   V o=x.o+S.posbias+N3(S.npos);Q oq=qm(x.oq,qrot(S.rotbias+N3(S.nrot)));qn(oq);V gg=x.g+N3(2e-6);
   fprintf(g,"%.3f,%g,%.6f,%.6f,%.6f,%.7f,%.7f,%.7f,%.7f,%.6f,%.6f,%.6f,%.7f,%.7f,%.7f,%.7f",x.t,x.cmd,gg.x,gg.y,gg.z,x.gq.w,x.gq.x,x.gq.y,x.gq.z,o.x,o.y,o.z,oq.w,oq.x,oq.y,oq.z);
   for(int k=0;k<3;k++){V fo=k<2?x.f[k]:x.pf,to=k<2?x.tq[k]:x.pt;
    V mis=S.mis[k];D gain=1+S.gain[k];
    if(k==0){mis=mis+V{S.p("sensor_misalignment","finger1_x_rad"),S.p("sensor_misalignment","finger1_y_rad"),S.p("sensor_misalignment","finger1_z_rad")};gain+=S.p("sensor_gain","finger1");}
    if(k==1){mis=mis+V{S.p("sensor_misalignment","finger2_x_rad"),S.p("sensor_misalignment","finger2_y_rad"),S.p("sensor_misalignment","finger2_z_rad")};gain+=S.p("sensor_gain","finger2");}
    if(k==2)gain+=S.p("sensor_gain","pusher");
    M A=mat(qrot(mis));fo=mul(A,fo)*gain;to=mul(A,to)*gain;
    D big=k<2?fo.y:fo.x;if(k<2){fo.x+=S.xt[k][0]*big;fo.z+=S.xt[k][1]*big;}else{fo.y+=S.xt[k][0]*big;fo.z+=S.xt[k][1]*big;}
    if(k<2){fo=fo+S.bF[k]+dF[k]+N3(S.noiseF);to=to+S.bT[k]+N3(S.noiseT);}else{fo=fo+S.bPF+dPF+N3(S.noisePF);to=to+S.bPT+N3(S.noisePT);}
    if(k==0)fo.x+=prog*S.p("unlisted:sensor_zero_drift","finger1_x_n_first_to_last");
    if(k==1)fo.z+=prog*S.p("unlisted:sensor_zero_drift","finger2_z_n_first_to_last");
    if(k==2)fo.x+=prog*S.p("unlisted:sensor_zero_drift","pusher_x_n_first_to_last");
    D qf=k<2?1/160.:1/80.,qt=k<2?1/32000.:1/2000.;
    fprintf(g,",%.5f,%.5f,%.5f,%.6f,%.6f,%.6f",qz(fo.x,qf),qz(fo.y,qf),qz(fo.z,qf),qz(to.x,qt),qz(to.y,qt),qz(to.z,qt));}
   fprintf(g,"\n");}
  fclose(g);}
 fclose(tc);
 mkdir((out+"/keys").c_str(),0755);f=fopen((out+"/keys/"+argv[2]+".json").c_str(),"w");
 fprintf(f,"{\n \"number\": %d, \"seed\": %llu,\n \"effects\": [",S.number,(unsigned long long)S.seed);bool fi=true;
 for(auto&e:S.eff){fprintf(f,"%s{\"id\": \"%s\", \"params\": {",fi?"":", ",e.first.c_str());fi=false;bool f2=true;for(auto&p:e.second){fprintf(f,"%s\"%s\": %.6g",f2?"":", ",p.first.c_str(),p.second);f2=false;}fprintf(f,"}}");}
 fprintf(f,"],\n \"mu_finger\": %.5f, \"mu_pusher\": %.5f, \"believed_mu_finger\": %.5f, \"believed_mu_pusher\": %.5f,\n \"pad_tangential_n_m\": %.6g, \"pad_normal_n_m\": %.6g, \"pusher_n_m\": %.6g, \"pusher_tangential_n_m\": %.6g,\n \"plate_yaw_rad\": %.6g, \"plate_pitch_rad\": %.6g, \"line_rad\": %.6g,\n \"trials\": %d, \"conditions\": %d,\n",S.muf,S.mup,S.believed_f,S.believed_p,S.kt,S.kn,S.kp,S.kpt,S.yaw,S.pitch,S.lineyaw,(int)ts.size(),nc);
 fprintf(f," \"length_m\": %g, \"side_m\": %g, \"mass_true_kg\": %.6g, \"mass_stated_kg\": %g, \"com_x_true_m\": %.6g, \"grasp_offset_x_m\": %g, \"gravity_true_m_s2\": [%.5f, %.5f, %.5f],\n",S.L,S.s,S.mass,S.mass_stated,S.com.x,S.ox,S.g.x,S.g.y,S.g.z);
 fprintf(f," \"pad_radius_nominal_m\": %g, \"pad_radius_true_m\": %.6g, \"pad_normal_hardening\": %.4g, \"pad_crown\": %.4g, \"pad_stiffening_exponent\": %.4g, \"pad_viscoelastic_share\": %.4g, \"pad_viscoelastic_s\": %.4g, \"slider_spread\": %.4g,\n \"friction_scatter_finger\": %.4g, \"friction_scatter_pusher\": %.4g, \"grip_scatter\": %.4g, \"jaw_servo_s\": %.4g, \"grips_n\": [%g, %g, %g], \"speeds_m_s\": [%g, %g, %g], \"load_reference_n\": 25, \"dt_s\": %g,\n",S.a,S.a_true,S.nq,S.crown,S.stiff_exp,S.sls,S.sls_tau,S.spread,S.rep_sc,S.rep_sc_p,S.grip_sc,S.jaw_tau,g1,g2,g3,v1,sp[1],v3,S.dt);
 auto pv=[&](const char*n,V a,const char*e){fprintf(f," \"%s\": [%.5g, %.5g, %.5g]%s\n",n,a.x,a.y,a.z,e);};
 pv("bias_finger1_n",S.bF[0],",");pv("bias_finger2_n",S.bF[1],",");pv("bias_pusher_n",S.bPF,",");pv("bias_pusher_nm",S.bPT,",");pv("gain_nuisance",{S.gain[0],S.gain[1],S.gain[2]},",");pv("misalignment_finger1_nuisance",S.mis[0],",");pv("misalignment_finger2_nuisance",S.mis[1],",");pv("pose_bias_m",S.posbias,"");
 fprintf(f,"}\n");fclose(f);
 printf("%d done, %d trials, %d conditions\n",S.number,(int)ts.size(),nc);
}
