// sim7: rigid object (6 dof) between two patch-grid pads, pushed against a fixed pusher.
// usage: sim7 NUMBER SEED EFFECTS OUTDIR KEY.json [step_scale [clean]]
#include <cstdio>
#include <cstdlib>
#include <cmath>
#include <cstring>
#include <string>
#include <vector>
#include <random>
#include <map>
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>
using namespace std;
typedef double D;
struct V{D x=0,y=0,z=0;};
static V operator+(V a,V b){return{a.x+b.x,a.y+b.y,a.z+b.z};}
static V operator-(V a,V b){return{a.x-b.x,a.y-b.y,a.z-b.z};}
static V operator*(D s,V a){return{s*a.x,s*a.y,s*a.z};}
static D dot(V a,V b){return a.x*b.x+a.y*b.y+a.z*b.z;}
static V cross(V a,V b){return{a.y*b.z-a.z*b.y,a.z*b.x-a.x*b.z,a.x*b.y-a.y*b.x};}
static D nrm(V a){return sqrt(dot(a,a));}
static V unit(V a){return (1/nrm(a))*a;}
struct Q{D w=1,x=0,y=0,z=0;};
static Q mul(Q a,Q b){return{a.w*b.w-a.x*b.x-a.y*b.y-a.z*b.z,a.w*b.x+a.x*b.w+a.y*b.z-a.z*b.y,a.w*b.y-a.x*b.z+a.y*b.w+a.z*b.x,a.w*b.z+a.x*b.y-a.y*b.x+a.z*b.w};}
static Q rv(V r){D t=nrm(r);if(t<1e-9)return{1,r.x/2,r.y/2,r.z/2};D s=sin(t/2)/t;return{cos(t/2),s*r.x,s*r.y,s*r.z};}
static Q nq(Q q){D n=sqrt(q.w*q.w+q.x*q.x+q.y*q.y+q.z*q.z);return{q.w/n,q.x/n,q.y/n,q.z/n};}
static V rot(Q q,V v){V u{q.x,q.y,q.z};V t=2*cross(u,v);return v+q.w*t+cross(u,t);}
static Q conj(Q q){return{q.w,-q.x,-q.y,-q.z};}
struct Rng{ mt19937_64 g; explicit Rng(uint64_t s):g(s*0x9E3779B97F4A7C15ull+0x1234567){g.discard(8);} 
 D u(D a=0,D b=1){return uniform_real_distribution<D>(a,b)(g);} D n(D s=1){return normal_distribution<D>(0,s)(g);}
 D nc(D s,D c){D v=n(s);return max(-c,min(c,v));} D lu(D a,D b){return exp(u(log(a),log(b)));} int i(int a,int b){return uniform_int_distribution<int>(a,b)(g);}
 bool p(D q){return u()<q;} D sg(){return p(.5)?1:-1;} };
static const D PI=M_PI;
// ---------------------------------------------------------------- effects (neutral values)
struct Fx{
 D st_ex=0,st_v=.002,st_len=3e-5,visc=0,dw=0,dw_cut=.05,dw_ren=2e-5,ldexp=0,aniso=1,mism=0,wear=0; int wear_mode=0;
 D dR=0,pox=0,poz=0,wedge=0,mugrad=0; D wav_mu=0,wav_thick=0,wav_l=.008,wav_ph=0,wav_h2=0,wav_h3=0;
 D pt_pitch=0,pt_yaw=0,adh=0,gl_frac=0,gl_off=0; D lag_drop=0,lag_knee=1e-3,lag_tau=.1,lag_slip=0,lag_pull=0;
 D m_frac=0,com_x=0; V ext; D ext_k=0,ext_at=0; D tilt_x=0,tilt_y=0,roll=0; D sb[18]={0},sg[3]={0}; V sm[3]; D xt[2][5]={{0}},xtp[5]={0}; D lat=0;
 D clamp_f=0,chat_a=0,chat_l=2e-4,gain_drift[3]={0},oil_d=0,oil_x=0,oil_z=0,oil_r=.005,flex_b=0,flex_a=0,heat=0;
};
struct Cond{int kind;D grip,speed,slope,off;D pause;D dist;int run;int id;};
struct Rig{
 D L,S,H,mass,rad,K[2],muF,muP,mF[2]; D ca,cb,Cn[2],crown,kapN,tauN,kapT,tauT,stiffexp,layer; D e[3],s[3]; D un[2][80];
 D kj,cj,gg,gtau; D tau_arm,acc; int pk; D plen,tipr,pivlen; D Kp,pexp,pt_ratio,hc; D fs; int rep; D ref_mu;
 V padoff[2]; V psq; V sorg[3],sax[3]; D sgain[3]; D bias[18],drift[18]; D frvar,gripnoise,gposnoise,wander,clock; D uneven;
 D nf,nfu,nt,ntu,pf,pfu,ptq,ptu,pp,pr; D setup_p,setup_r; D gap; D rest; D padtilt[2][2]; D rampt; D gripN0;
};
static const int NP=80;
struct Pad{ alignas(64) D rx[NP],rz[NP],w[NP],kw[NP],h[NP],mu[NP],zn[NP],znn[NP],p[NP],kn[NP],fx[NP],fz[NP],slip[NP],kxx[NP],kxz[NP],kzz[NP];
 alignas(64) D q[2][3][2][NP],z[2][3][2][NP]; D sw[NP],age[NP],wadd[NP]; int cur=0;
 D Y,e; D N,Fx,Fz,M,Nx,Nz; D heat=0; };
struct Samp{D t;V gp;Q gq;V op;Q oq;V F[3],T[3];};
struct Stat{D bal=0,balrms=0,over=0,steady=0;long nb=0,ns=0,it=0,steps=0;};
static bool solve(D*A,D*b,int n){ // in place Gauss, partial pivot
 for(int k=0;k<n;k++){int p=k;D m=fabs(A[k*n+k]);for(int i=k+1;i<n;i++)if(fabs(A[i*n+k])>m){m=fabs(A[i*n+k]);p=i;}
  if(m==0)return false; if(p!=k){for(int j=k;j<n;j++)swap(A[k*n+j],A[p*n+j]);swap(b[k],b[p]);}
  D iv=1/A[k*n+k];for(int i=k+1;i<n;i++){D f=A[i*n+k]*iv;if(f==0)continue;for(int j=k+1;j<n;j++)A[i*n+j]-=f*A[k*n+j];b[i]-=f*b[k];}}
 for(int i=n-1;i>=0;i--){D s=b[i];for(int j=i+1;j<n;j++)s-=A[i*n+j]*b[j];b[i]=s/A[i*n+i];}return true;}
// pad evaluation: a = increment of object relative to the pad (x, z, turn), delta = A + Bx rx + Bz rz - h
static void evalPad(Pad&P,const Rig&R,int f,D Kt,D dt,D ax,D az,D ph,D A,D Bx,D Bz,const D*thick,D adh,D Axx,D Axz,D Azz){
 const int c=P.cur; const D rN=dt/R.tauN,bN=1/(1+rN),rT=dt/R.tauT,bT=R.kapT/(1+rT),g1=1+bT,ig1=1/g1,irT=1/(1+rT),kap=R.kapN*bN,C=R.Cn[f],ca=R.ca,cb=R.cb,idt=1/dt;
 const D e0=R.e[0],e1=R.e[1],e2=R.e[2],s0=R.s[0],s1=R.s[1],s2=R.s[2];
 #pragma GCC ivdep
 for(int i=0;i<NP;i++){ D d=A+Bx*P.rx[i]+Bz*P.rz[i]-P.h[i]+thick[i]; D dp=d>0?d:0; D a=sqrt(dp),b=sqrt(a); D g=dp*(ca*a+cb*b),gd=1.5*ca*a+1.25*cb*b;
  D zz=P.zn[i]; D pr=g+kap*(g-zz); D pos=pr>0?1:0; P.znn[i]=(zz+rN*g)*bN; P.p[i]=C*P.w[i]*pr*pos; P.kn[i]=C*P.w[i]*gd*(1+kap)*pos; P.fx[i]=P.fz[i]=P.slip[i]=P.kxx[i]=P.kxz[i]=P.kzz[i]=0; }
 const D ek[3]={e0,e1,e2},sk[3]={s0,s1,s2};
 for(int k=0;k<3;k++){ const D*q0=P.q[c][k][0],*q1=P.q[c][k][1],*z0=P.z[c][k][0],*z1=P.z[c][k][1]; D*o0=P.q[1-c][k][0],*o1=P.q[1-c][k][1],*y0=P.z[1-c][k][0],*y1=P.z[1-c][k][1]; const D e=ek[k],s=sk[k];
  #pragma GCC ivdep
  for(int i=0;i<NP;i++){ D ux=ax+ph*P.rz[i],uz=az-ph*P.rx[i]; D k0=Kt*P.kw[i]*e; D tx=q0[i]+ux,tz=q1[i]+uz; D fx=k0*(g1*tx-bT*z0[i]),fz=k0*(g1*tz-bT*z1[i]);
   D n=sqrt(Axx*fx*fx+2*Axz*fx*fz+Azz*fz*fz)+1e-30; D lim=P.mu[i]*s*(P.p[i]+adh*P.w[i]*(P.p[i]>0?1.0:0.0)); D r=lim/n; D sl=r<1?1:0; r=r<1?r:1; D gx=fx*r,gz=fz*r;
   D ik=ig1/k0; D qx=gx*ik+bT*ig1*z0[i],qz=gz*ik+bT*ig1*z1[i]; qx=sl>0?qx:tx; qz=sl>0?qz:tz;
   o0[i]=qx;o1[i]=qz; y0[i]=(z0[i]+rT*qx)*irT; y1[i]=(z1[i]+rT*qz)*irT; P.fx[i]+=gx;P.fz[i]+=gz; D dx=tx-qx,dz=tz-qz; P.slip[i]+=s*sqrt(dx*dx+dz*dz)*idt;
   D kt=k0*g1*r; D in=sl/(fx*fx+fz*fz+1e-30); P.kxx[i]+=kt*(1-fx*fx*in);P.kxz[i]-=kt*fx*fz*in;P.kzz[i]+=kt*(1-fz*fz*in); } }
}
struct PPoint{V b;D w;D q[2][3][2];D p,f1,f2,pr;V P;bool on;};
static void simulate(const Rig&R,const Fx&E,const Cond&C,D wearF,D cumheat,uint64_t seed,D scale,vector<Samp>&out,Stat&st,D&tot_slip){
 Rng g(seed); D mass=R.mass*(1+E.m_frac); V Ib{mass*(R.S*R.S+R.H*R.H)/12,mass*(R.L*R.L+R.H*R.H)/12,mass*(R.L*R.L+R.S*R.S)/12};
 D Ts=1/R.fs; int nsub=max(1,(int)ceil(Ts/(1.25e-4*scale)-1e-9)); D dt=Ts/nsub;
 D muVar=1+g.nc(R.frvar,2.5*R.frvar); D muPv=R.muP*(1+g.nc(R.frvar,2.5*R.frvar)); D muf[2]; for(int f=0;f<2;f++)muf[f]=R.mF[f]*muVar*wearF*(1+(f?-E.mism:E.mism))*(1+g.nc(.25*R.frvar,R.frvar));
 Pad*pd=new Pad[2]; D Rp=max(.45*R.rad,R.rad+E.dR);
 for(int f=0;f<2;f++){Pad&P=pd[f];memset((void*)&P,0,sizeof(Pad)); int i=0; D sumw=0,sumk=0; for(int a=0;a<5;a++)for(int b=0;b<16;b++,i++){ D r0=a/5.,r1=(a+1)/5.; D r=2./3*(r1*r1*r1-r0*r0*r0)/(r1*r1-r0*r0)*Rp*1.0; D th=2*PI*(b+.5*(a&1))/16; D lx=r*cos(th),lz=r*sin(th);
   P.rx[i]=lx+R.padoff[f].x+E.pox;P.rz[i]=lz+R.padoff[f].z+E.poz; P.w[i]=(r1*r1-r0*r0)/16*(1+R.un[f][i]); P.kw[i]=P.w[i]*(1-R.layer*r*r/(Rp*Rp)); sumw+=P.w[i];sumk+=P.kw[i]; P.h[i]=R.crown*r*r/(Rp*Rp)+R.padtilt[f][0]*lx+R.padtilt[f][1]*lz; P.sw[i]=1;P.age[i]=1.0; }
  for(i=0;i<NP;i++){P.w[i]/=sumw;P.kw[i]/=sumk;} }
 // object and gripper
 V op{g.nc(R.setup_p,3*R.setup_p),0,g.nc(R.setup_p,3*R.setup_p)}; Q oq=rv({g.nc(R.setup_r*.5,R.setup_r),g.nc(R.setup_r,2*R.setup_r),g.nc(R.setup_r*.5,R.setup_r)}); V p0=op;Q q0=oq; V v,w; 
 bool piv=C.kind==1; int pk=piv?1:R.pk;
 // pusher nominal frame; gap fixes its place
 V Po;Q Pq; V m0; D sface; if(piv){Po={-(R.L/2-.005)+C.off,0,-(R.H/2+R.gap)};Pq=rv({0,-PI/2,0});m0={0,0,-1};sface=R.H/2;}
 else{Po={-(R.L/2+R.gap)-(pk==2?R.tipr:0),0,pk==0?0:C.off};Pq={};m0={-1,0,0};sface=R.L/2;}
 Q Pt=mul(Pq,rv({R.psq.x,R.psq.y+E.pt_pitch,R.psq.z+E.pt_yaw})); V px=rot(Pt,{1,0,0}),py=rot(Pt,{0,1,0});
 vector<PPoint> pp; if(pk==0){for(int a=0;a<6;a++)for(int b=0;b<6;b++){PPoint q{};q.b={-R.L/2,R.S*((a+.5)/6-.5),R.H*((b+.5)/6-.5)};q.w=1./36;pp.push_back(q);}}
 else if(pk==1){D ln=piv?R.pivlen:R.plen;for(int a=0;a<9;a++){PPoint q{};q.b={0,ln*((a+.5)/9-.5),0};q.w=1./9;pp.push_back(q);}} else {PPoint q{};q.w=1;pp.push_back(q);}
 D F0=10,dref=F0/R.Kp; D Kpush=R.Kp*(E.flex_a>0?1/(1+R.Kp*E.flex_a):1); dref=F0/Kpush; D Cp=F0/pow(dref,R.pexp)/R.pexp;Cp=Cp*pow(R.pexp,1.0);
 int pc=0; D Mroll=0; V FP,TP; V clampc; V clv;
 D t=-0.45; D s=0,sv=0,str=0; D total=C.dist; D tend; { D vmax=C.speed; tend=R.rest+total/vmax+R.rampt+C.pause+.35; }
 V gpos;D ang=0; D wandx=0,wandz=0; D gn=0; D etrial=g.nc(.003,.006); D Fgo=C.grip; D slipacc=0,lagst=0; 
 D Nref=R.gripN0; D dirx=-cos(C.slope),dirz=sin(C.slope); bool paused=false;D pt0=-1;
 pd[0].Y=pd[1].Y=R.S/2+1e-5; D wj=R.S/2+1e-5,ej[2]={0,0}; D Npr[2]={0,0}; D slipv=0,pull=0; D heatJ=cumheat; D waved[2][NP]; memset(waved,0,sizeof waved);
 auto wave=[&](D x){D a=2*PI*x/E.wav_l+E.wav_ph;return sin(a)+E.wav_h2*sin(2*a+1)+E.wav_h3*sin(3*a+2);};
 D wgain=1; if(E.wav_mu!=0||E.wav_thick!=0){ // mean over the pad: gain so that the pad's mean shows the amplitude
   D sc=0,ss=0,sw=0;for(int i=0;i<NP;i++){D a=2*PI*(pd[0].rx[i])/E.wav_l;sc+=pd[0].w[i]*cos(a);ss+=pd[0].w[i]*sin(a);sw+=pd[0].w[i];} D m=sqrt(sc*sc+ss*ss)/sw; wgain=min(6.0,1/max(m,.05)); if(fabs(E.wav_mu)*wgain>.85)wgain=.85/fabs(E.wav_mu); }
 out.clear(); long istep=0; long n0=(long)llround(0.45/Ts)*nsub; t=-(D)n0*dt; 
 V gvec{0,0,-9.81}; gvec=rot(rv({E.tilt_x,E.tilt_y,0}),gvec);
 bool fric_dyn=E.st_ex!=0||E.visc!=0||E.dw!=0; bool place=E.mugrad!=0||E.wav_mu!=0||E.oil_d!=0||E.wav_thick!=0; D dispx=0; V opStart=op; bool started=false; V dpl,dthl;
 D sprev=0; D wphase=g.u(0,6.28);
 while(t<tend){
  t+=dt; istep++;
  // ---- path
  D vt=0; if(t>R.rest&&s<total-1e-12){vt=C.speed; if(C.pause>0&&!paused&&s>=total*.5){paused=true;pt0=t;} if(paused&&t<pt0+C.pause)vt=0;} D acc=C.speed/R.rampt; { D need=sv*sv/(2*acc); if(s+need>=total-sv*dt)vt=0; }
  if(sv<vt)sv=min(vt,sv+acc*dt);else if(sv>vt)sv=max(vt,sv-acc*dt); if(t>R.rest&&s<total&&vt==0&&sv<=0&&!(paused&&t<pt0+C.pause)){ s=total; } s+=sv*dt; if(s>total)s=total;
  D sc=s; if(E.chat_a>0){D x=s/E.chat_l;x-=floor(x);sc=s-E.chat_a*x*(s>0);} str+=(sc-str)*dt/(R.tau_arm+dt);
  D sl=str; wandx=R.wander*sin(2*PI*.7*t+wphase);wandz=R.wander*sin(2*PI*.5*t+2*wphase); if(t<0){wandx=R.wander*sin(wphase);wandz=R.wander*sin(2*wphase);}
  V gnew;D anew=0; if(piv){anew=-sl;gnew={wandx,0,wandz};}else gnew={dirx*sl+wandx,0,dirz*sl+wandz};
  Q gq=rv({0,anew,0}); V dgw=gnew-gpos; V dgl=rot(conj(gq),dgw); D dga=anew-ang;
  // ---- grip command seen by the force loop
  gn+=-gn*dt/.05+R.gripnoise*sqrt(2*dt/.05)*g.n(); 
  D target=C.grip*(1+etrial+gn); target=target*(1-E.gl_frac)-E.gl_off; D dropt=E.lag_drop*slipv/(slipv+E.lag_knee); lagst+=(dropt-lagst)*dt/(E.lag_tau+dt); if(t>0)slipacc+=slipv*dt; target*=1-lagst-(1-exp(-E.lag_slip*slipacc)); target-=E.lag_pull*pull; if(target<.5)target=.5;
  if(t<-.25)target*=min(1.0,(t+.45+.02)/.15);
  D fix=t<-.2?1:(t<-.1?(-.1-t)/.1:0); if(fix<0)fix=0;
  if(!started&&t>=0){started=true;opStart=op;}
  // ---- friction of patches (explicit states)
  V opg=rot(conj(gq),op-gnew); Q qr=mul(conj(gq),oq); V Xo=rot(qr,{1,0,0}),Yo=rot(qr,{0,1,0}),Zo=rot(qr,{0,0,1});
  D ratio=sqrt(E.aniso); D c2=Xo.x,s2=Xo.z; {D n=sqrt(c2*c2+s2*s2);c2/=n;s2/=n;} D ia=1/(ratio*ratio),ib=ratio*ratio; D Axx=c2*c2*ia+s2*s2*ib,Azz=s2*s2*ia+c2*c2*ib,Axz=c2*s2*(ia-ib);
  for(int f=0;f<2;f++){ Pad&P=pd[f]; D base=muf[f]; if(E.ldexp!=0)base*=pow(max(Npr[f],1.)/Nref,-E.ldexp); if(E.heat>0)base*=exp(-E.heat*heatJ);
   if(!fric_dyn&&!place){for(int i=0;i<NP;i++)P.mu[i]=base;} else for(int i=0;i<NP;i++){ D m=base; D vs=P.slip[i];
     if(E.st_ex!=0){m*=1+E.st_ex*P.sw[i];} if(E.visc!=0){P.wadd[i]+=(vs-P.wadd[i])*dt/(.002+dt);m*=1+0;m+=E.visc*P.wadd[i];} if(E.dw!=0)m*=1+E.dw*log(1+P.age[i]/E.dw_cut);
     if(place){D rx=P.rx[i]-opg.x,rz=P.rz[i]-opg.z; D xo=rx*Xo.x+rz*Xo.z,zo=rx*Zo.x+rz*Zo.z; D fct=1+E.mugrad*xo; if(E.wav_mu!=0)fct+=E.wav_mu*wgain*wave(xo); if(E.oil_d>0){D dx=xo-E.oil_x,dz=zo-E.oil_z;fct*=1-E.oil_d*exp(-pow((dx*dx+dz*dz)/(E.oil_r*E.oil_r),2));} m*=max(.05,fct); if(E.wav_thick!=0)waved[f][i]=E.wav_thick*wgain*wave(xo);}
     P.mu[i]=m; } }
  // ---- Newton
  V dp=dt*v,dth=dt*w; D Yd[3]={wj,ej[0],ej[1]}; V Ft,Tt; int it; V FPn,TPn; D Mrn=0; V rF[2],rT[2]; V inertF; bool pcont=false; D Npush=0; V nx;
  D Kt[2]; for(int f=0;f<2;f++)Kt[f]=R.K[f]*pow(max(Npr[f],.3)/Nref,R.stiffexp);
  bool conv=false;
  for(it=0;it<8;it++){
   V pn=op+dp; Q qn=mul(rv(dth),oq); V pg=rot(conj(gq),pn-gnew); Q ql=mul(conj(gq),qn); V X=rot(ql,{1,0,0}),Y=rot(ql,{0,1,0}),Z=rot(ql,{0,0,1}); V dl=rot(conj(gq),dp),wl=rot(conj(gq),dth);
   D J[81]={0},r[9]={0}; D Kg[36]={0}; D Fg[6]={0}; 
   for(int f=0;f<2;f++){ Pad&P=pd[f]; D sgn=f?-1:1; D ry=sgn*R.S/2; D Yp=Yd[0]+Yd[1+f]; V n1=unit(V{sgn*Y.x,sgn*Y.y,sgn*Y.z}+(-E.wedge)*X);
    // delta = S/2 + wedge*xo - (P-p).n ; P=(rx, sgn*Yp, rz)
    V nn{sgn*Y.x,sgn*Y.y,sgn*Y.z}; D base=R.S/2-((-pg.x)*nn.x+(sgn*Yp-pg.y)*nn.y+(-pg.z)*nn.z)+E.wedge*(-pg.x*X.x-pg.z*X.z+0); D Bx=-nn.x+E.wedge*X.x,Bz=-nn.z+E.wedge*X.z;
    D ax=dl.x-wl.z*ry-wl.y*pg.z-dgl.x+dga*0, az=dl.z+wl.x*ry+wl.y*pg.x-dgl.z, ph=wl.y-dga; if(f==0){ax-=clv.x;az-=clv.z;}
    evalPad(P,R,f,Kt[f],dt,ax,az,ph,base,Bx,Bz,waved[f],E.adh,Axx,Axz,Azz);
    D N=0,Nx=0,Nz=0,a0=0,a1=0,a2=0,a11=0,a22=0,a12=0,Fx=0,Fz=0,M=0,k00=0,k01=0,k11=0,k02=0,k12=0,k22=0;
    #pragma GCC ivdep
    for(int i=0;i<NP;i++){D x=P.rx[i],z=P.rz[i],p=P.p[i],k=P.kn[i];N+=p;Nx+=p*x;Nz+=p*z;a0+=k;a1+=k*x;a2+=k*z;a11+=k*x*x;a22+=k*z*z;a12+=k*x*z;Fx+=P.fx[i];Fz+=P.fz[i];M+=z*P.fx[i]-x*P.fz[i];
     D u=P.kxx[i],m=P.kxz[i],q=P.kzz[i];k00+=u;k01+=m;k11+=q;k02+=u*z-m*x;k12+=m*z-q*x;k22+=u*z*z-2*m*x*z+q*x*x;}
    P.N=N;P.Fx=Fx;P.Fz=Fz;P.M=M;P.Nx=Nx;P.Nz=Nz;
    // normal: generalised direction b (object push out along n1): force on object = -p n1
    V r0{-pg.x,ry,-pg.z}; V c0=cross(r0,n1),cX=cross(V{1,0,0},n1),cZ=cross(V{0,0,1},n1); D b0[6]={n1.x,n1.y,n1.z,c0.x,c0.y,c0.z},bX[6]={0,0,0,cX.x,cX.y,cX.z},bZ[6]={0,0,0,cZ.x,cZ.y,cZ.z};
    // tangential rows
    D B0[6]={1,0,0,0,-pg.z,-ry},B1[6]={0,0,1,ry,pg.x,0},B2[6]={0,0,0,0,1,0};
    for(int i=0;i<6;i++){ Fg[i]+=-N*b0[i]-Nx*bX[i]-Nz*bZ[i]-Fx*B0[i]-Fz*B1[i]-M*B2[i];
     D v0=a0*b0[i]+a1*bX[i]+a2*bZ[i],v1=a1*b0[i]+a11*bX[i]+a12*bZ[i],v2=a2*b0[i]+a12*bX[i]+a22*bZ[i]; D t0=k00*B0[i]+k01*B1[i]+k02*B2[i],t1=k01*B0[i]+k11*B1[i]+k12*B2[i],t2=k02*B0[i]+k12*B1[i]+k22*B2[i];
     for(int j=0;j<6;j++)Kg[i*6+j]+=v0*b0[j]+v1*bX[j]+v2*bZ[j]+t0*B0[j]+t1*B1[j]+t2*B2[j];
     P.wadd[0]+=0; // couplings to the jaw
     J[i*9+7+f]=-v0; J[(7+f)*9+i]=-v0; }
    J[(7+f)*9+6]+=a0; J[(7+f)*9+7+f]=a0+R.kj+R.cj/dt; r[7+f]=R.cj*(Yd[1+f]-ej[f])/dt+R.kj*Yd[1+f]-N; J[6*9+7+f]=R.gg*a0/2; J[6*9+6]+=R.gg*a0/2;
    // small component of friction along y because the face is not quite square
    D fy=(n1.x*Fx+n1.z*Fz)/n1.y; Fg[1]+=fy; V tf=cross(V{-pg.x,ry,-pg.z},V{0,fy,0}); Fg[3]+=tf.x;Fg[5]+=tf.z;
    rF[f]={-N*n1.x-Fx,-N*n1.y+fy,-N*n1.z-Fz}; V rc=N>1e-9?V{Nx/N,0,Nz/N}:V{}; V tn=cross(rc,(-N)*n1); rT[f]={tn.x,tn.y-M,tn.z}; }
   for(int i=0;i<6;i++)J[6*9+i]=0; for(int f=0;f<2;f++)for(int i=0;i<6;i++){J[6*9+i]+=-R.gg/2*(-J[i*9+7+f]);J[i*9+6]+=J[i*9+7+f];}
   J[6*9+6]+=1/dt; r[6]=(Yd[0]-wj)/dt+R.gg*(target-(pd[0].N+pd[1].N)/2);
   // residual of forces in gripper axes
   V Fw=rot(gq,V{Fg[0],Fg[1],Fg[2]}),Tw=rot(gq,V{Fg[3],Fg[4],Fg[5]});
   // to the world: pusher, gravity, fixture; keep world forces then rotate back
   V Fe=mass*gvec,Te; if(E.com_x!=0)Te=cross(rot(qn,V{E.com_x,0,0}),Fe); if(t>-1&&(E.ext.x||E.ext.y||E.ext.z)){D l=nrm(E.ext);V d=(1/l)*E.ext;D tr=dot(pn,d);V F=(l-E.ext_k*tr)*d;Fe=Fe+F;Te=Te+cross(rot(qn,V{E.ext_at,0,0}),F);}
   D Kw[36]={0}; 
   if(fix>0){D kf=2e5*fix,kr=50*fix,cf=200*fix,cr=.05*fix; V d=pn-p0; Q dq=mul(qn,conj(q0)); V dr{2*dq.x,2*dq.y,2*dq.z}; V F=(-kf)*V{d.x,0,d.z}+(-cf/dt)*V{dp.x,0,dp.z}; Fe=Fe+F; Te=Te+(-kr)*dr+(-cr/dt)*dth; Kw[0]+=kf+cf/dt;Kw[14]+=kf+cf/dt;for(int i=3;i<6;i++)Kw[i*7]+=kr+cr/dt;}
   // pusher
   V F_p,T_p; bool cont=false; D Nt=0; { V nO=rot(qn,m0); V nI=pk==0?px:(-1.0)*nO; V t1=unit(py-dot(py,nI)*nI),t2=cross(nI,t1); V Xw=rot(qn,{1,0,0}),Yw=rot(qn,{0,1,0}),Zw=rot(qn,{0,0,1});
    D Kt0=R.pt_ratio*Kpush;
    for(auto&a:pp){ V P;D d; if(pk==0){P=pn+rot(qn,a.b);d=-dot(P-Po,px);}else{P=Po+rot(Pt,a.b);d=sface-dot(P-pn,nO);if(pk==2){d+=R.tipr;P=P+(R.tipr)*nI;} V rr=P-pn; if(fabs(dot(rr,Yw))>R.S/2||(piv?fabs(dot(rr,Xw))>R.L/2:fabs(dot(rr,Zw))>R.H/2))d=-1;}
     a.P=P;a.on=d>0; if(!a.on){a.p=a.f1=a.f2=a.pr=0;memset(a.q[1-pc],0,sizeof a.q[0]);continue;} cont=true;
     V rr=P-pn; V du=dp+cross(dth,rr); D dn=-dot(du,nI)/dt; D hc=max(0.,1+R.hc*dn); D el=Cp*a.w*pow(d,R.pexp); a.p=el*hc; D kn=Cp*a.w*R.pexp*pow(d,R.pexp-1)*hc+(hc>0?el*R.hc/dt:0); Nt+=a.p; D u1=dot(du,t1),u2=dot(du,t2); a.f1=a.f2=0;D k11=0,k12=0,k22=0,cmp=0; 
     for(int k=0;k<3;k++){D kk=Kt0*a.w*R.e[k];D x=a.q[pc][k][0]+u1,y=a.q[pc][k][1]+u2;D fx=kk*x,fy=kk*y,n=sqrt(fx*fx+fy*fy)+1e-30,lim=muPv*a.p*R.s[k];D r=lim/n; if(r<1){fx*=r;fy*=r;x*=r;y*=r;D kt=kk*r;D h=1/(lim*lim+1e-30);k11+=kt*(1-fx*fx*h);k12-=kt*fx*fy*h;k22+=kt*(1-fy*fy*h);}else{k11+=kk;k22+=kk;} a.q[1-pc][k][0]=x;a.q[1-pc][k][1]=y;a.f1+=fx;a.f2+=fy;}
     V F=a.p*nI+(-a.f1)*t1+(-a.f2)*t2; F_p=F_p+F;T_p=T_p+cross(rr,F); (void)cmp;
     V cn=cross(rr,nI),c1=cross(rr,t1),c2=cross(rr,t2); D bn[6]={nI.x,nI.y,nI.z,cn.x,cn.y,cn.z},b1[6]={t1.x,t1.y,t1.z,c1.x,c1.y,c1.z},b2[6]={t2.x,t2.y,t2.z,c2.x,c2.y,c2.z};
     for(int i=0;i<6;i++){D x=kn*bn[i],y=k11*b1[i]+k12*b2[i],z=k12*b1[i]+k22*b2[i];for(int j=0;j<6;j++)Kw[i*6+j]+=x*bn[j]+y*b1[j]+z*b2[j];} }
    Mrn=0; if(E.roll>0&&cont){D lim=E.roll*Nt,kr=lim/.002;D m=Mroll+kr*dot(dth,py);if(fabs(m)<lim)for(int i=0;i<3;i++)for(int j=0;j<3;j++){D a[3]={py.x,py.y,py.z};Kw[(3+i)*6+3+j]+=kr*a[i]*a[j];} m=max(-lim,min(lim,m));Mrn=m;T_p=T_p+(-m)*py;} }
   pcont=cont;Npush=Nt;
   V wn=(1/dt)*dth,vn=(1/dt)*dp; V iF=(mass/dt)*(vn-v); V dwb=rot(conj(qn),(1/dt)*(wn-w)); V iT=rot(qn,V{Ib.x*dwb.x,Ib.y*dwb.y,Ib.z*dwb.z});
   V RF=iF-Fw-Fe-F_p,RT=iT-Tw-Te-T_p; 
   V rFl=rot(conj(gq),RF),rTl=rot(conj(gq),RT); r[0]=rFl.x;r[1]=rFl.y;r[2]=rFl.z;r[3]=rTl.x;r[4]=rTl.y;r[5]=rTl.z;
   FPn=F_p;{ V o=Po; D arm=0;(void)arm; TPn=T_p+cross(pn-o,F_p); } inertF=RF;
   D ef=nrm(RF),et=nrm(RT),ew=fabs(r[6])/R.gg,ee=max(fabs(r[7]),fabs(r[8]));
   if(it>0&&ef<1e-3&&et<1e-5&&ew<2e-3&&ee<2e-3){conv=true;break;}
   if(it==7)break;
   // jacobian: gripper part + world part turned into gripper axes + inertia
   V ex[3]={rot(gq,V{1,0,0}),rot(gq,V{0,1,0}),rot(gq,V{0,0,1})}; D G[9]={ex[0].x,ex[1].x,ex[2].x,ex[0].y,ex[1].y,ex[2].y,ex[0].z,ex[1].z,ex[2].z};
   for(int a=0;a<2;a++)for(int b=0;b<2;b++){D t1[9];for(int i=0;i<3;i++)for(int j=0;j<3;j++){D s=0;for(int k=0;k<3;k++)s+=Kw[(3*a+i)*6+3*b+k]*G[k*3+j];t1[i*3+j]=s;} for(int i=0;i<3;i++)for(int j=0;j<3;j++){D s=0;for(int k=0;k<3;k++)s+=G[k*3+i]*t1[k*3+j];Kg[(3*a+i)*6+3*b+j]+=s;}}
   for(int i=0;i<3;i++)Kg[i*7]+=mass/(dt*dt); D im[3]={Ib.x,Ib.y,Ib.z}; V ax3[3]={X,Y,Z}; for(int a=0;a<3;a++){D c[3]={ax3[a].x,ax3[a].y,ax3[a].z};for(int i=0;i<3;i++)for(int j=0;j<3;j++)Kg[(3+i)*6+3+j]+=im[a]*c[i]*c[j]/(dt*dt);}
   for(int i=0;i<6;i++)for(int j=0;j<6;j++)J[i*9+j]=Kg[i*6+j];
   for(int i=0;i<9;i++)r[i]=-r[i]; if(!solve(J,r,9))break;
   V a=rot(gq,V{r[0],r[1],r[2]}),b=rot(gq,V{r[3],r[4],r[5]}); D cap=2e-4; D m=max(nrm(a),nrm(b)*.03); D q=m>cap?cap/m:1; dp=dp+q*a;dth=dth+q*b;Yd[0]+=q*r[6];Yd[1]+=q*r[7];Yd[2]+=q*r[8];
  }
  st.it+=it+1;st.steps++; (void)conv;
  // commit
  op=op+dp;oq=nq(mul(rv(dth),oq));v=(1/dt)*dp;w=(1/dt)*dth;wj=Yd[0];ej[0]=Yd[1];ej[1]=Yd[2];FP=FPn;TP=TPn;Mroll=pcont?Mrn:0;pc^=1; if(!pcont)for(auto&a:pp){memset(a.q,0,sizeof a.q);}
  gpos=gnew;ang=anew; slipv=0;pull=0; D mup=0;
  for(int f=0;f<2;f++){Pad&P=pd[f];P.cur^=1;memcpy(P.zn,P.znn,sizeof P.zn);Npr[f]=P.N; D sv2=0,sN=0; D lims=0,minslip=1e9; for(int i=0;i<NP;i++){sv2+=P.p[i]*P.slip[i];sN+=P.p[i];lims+=P.mu[i]*(P.p[i]+(P.p[i]>0?E.adh*P.w[i]:0)); minslip=min(minslip,P.slip[i]);
     if(E.st_ex!=0){D x=P.slip[i],ss=exp(-x/E.st_v);D rate=x/E.st_len+1/.1*(x<1e-5);P.sw[i]+=(ss-P.sw[i])*(1-exp(-rate*dt));}
     if(E.dw!=0){D x=P.slip[i]/E.dw_ren;D k=x*dt;P.age[i]=k<1e-6?P.age[i]+dt:P.age[i]*exp(-k)+(1-exp(-k))/x;} }
   slipv+=.5*sv2/max(sN,1e-9); D Ftan=sqrt(P.Fx*P.Fx+P.Fz*P.Fz); pull+=.5*fabs(P.Fx); if(t>0){heatJ+=Ftan*sv2/max(sN,1e-9)*dt; heatJ-=heatJ*dt/8*.0;}
   if(t>0&&E.aniso==1){D ra=Ftan/max(lims,1e-9);st.over=max(st.over,ra-1);
     D vv=sqrt(pow(v.x-dgw.x/dt,2)+pow(v.z-dgw.z/dt,2)); if(minslip>.999*vv&&vv>.5*C.speed&&!piv&&fabs(w.y-dga/dt)*Rp<.005*vv){st.steady=max(st.steady,fabs(ra-1));st.ns++;} } (void)mup;}
  // finger slipping in its clamp
  clv={}; if(E.clamp_f>0&&t>0){Pad&P=pd[0];D F=sqrt(P.Fx*P.Fx+P.Fz*P.Fz);D lim=E.clamp_f*C.grip;if(F>lim){D eta=6*R.K[0]*2e-4;D k=(F-lim)/eta*dt/F;clv={-P.Fx*k*-1,0,P.Fz*k};clv={k*P.Fx,0,k*P.Fz};clampc=clampc+clv;}}
  D bn=nrm(inertF); if(t>0){st.bal=max(st.bal,bn);st.balrms+=bn*bn;st.nb++;}
  if(istep>=n0&&(istep-n0)%nsub==0){ Samp S;S.t=(istep-n0)*dt;S.gp=gnew;S.gq=gq;S.op=op;S.oq=oq; if(E.flex_b>0){V Tq=TP+cross(Po-op,FP);Tq=E.flex_b*Tq;S.oq=nq(mul(rv((-1.0)*Tq),oq));S.op=op+cross((-1.0)*Tq,rot(oq,{R.L*.4,0,0}));}
   for(int f=0;f<2;f++){S.F[f]=rF[f];S.T[f]=rT[f];} S.F[2]=FP;S.T[2]=TP;out.push_back(S);} 
 }
 tot_slip=heatJ-cumheat; 
 delete[] pd;
}
static string js(D v){char b[40];snprintf(b,40,"%.8g",v);return b;}
struct Key{vector<pair<string,string>> kv;void a(string k,D v){kv.push_back({k,js(v)});}void s(string k,string v){kv.push_back({k,"\""+v+"\""});}void r(string k,string v){kv.push_back({k,v});}
 string str()const{string o="{";for(size_t i=0;i<kv.size();i++)o+=(i?",":"")+string("\n  \"")+kv[i].first+"\": "+kv[i].second;return o+"\n}";}};
static const char*LISTED[]={"static_friction","viscous_friction","dwell_strengthening","load_dependent_friction","anisotropic_friction","finger_friction_mismatch","wear_drift","torsional_friction","pressure_offset","face_tilt","face_waviness","plate_tilt","adhesion","grip_force_loss","grip_force_lag","mass_error","external_force","gravity_tilt","rolling_resistance","sensor_bias","sensor_gain","sensor_misalignment","sensor_crosstalk","mocap_latency","x_clamp_slip","x_drive_chatter","x_gain_drift","x_oil_patch","x_object_flex","x_heating"};
int main(int argc,char**argv){
 if(argc==2&&string(argv[1])=="list"){for(auto l:LISTED)puts(l);return 0;}
 if(argc<6){fprintf(stderr,"usage: sim7 NUMBER SEED EFFECTS OUTDIR KEY.json [step_scale [clean]]\n");return 2;}
 long number=atol(argv[1]);uint64_t seed=strtoull(argv[2],0,10);string eff=argv[3],dir=argv[4];D scale=argc>6?atof(argv[6]):1;bool clean=argc>7;
 vector<string> ids;{stringstream ss(eff);string x;while(getline(ss,x,','))if(x!="none"&&!x.empty()){bool ok=false;for(auto l:LISTED)ok|=x==l;if(!ok){fprintf(stderr,"unknown effect %s\n",x.c_str());return 2;}ids.push_back(x);}}
 auto has=[&](string x){return find(ids.begin(),ids.end(),x)!=ids.end();};
 Rng g(seed*4+1),gp(seed*4+2),ge(seed*4+3); Rig R{}; R.fs=vector<D>{200,250,250,400,500,500}[g.i(0,5)];
 // object, pads
 R.L=1e-3*g.i(70,150);R.S=R.H=1e-3*g.i(18,40); if(g.p(.2))R.S=1e-3*g.i(15,40); D dia=1e-3*g.i(8,(int)min(25.,1e3*min(R.S,R.H)));dia=min(dia,min(R.S,R.H)); R.rad=dia/2;
 R.muF=g.lu(.25,1.0);R.muP=g.u(.2,.55); D mism=g.nc(.01,.02);R.mF[0]=R.muF*(1+mism);R.mF[1]=R.muF*(1-mism);
 int ng=g.i(1,4); if(has("load_dependent_friction")||has("adhesion")||has("grip_force_loss"))ng=max(ng,3); D gbase=g.lu(8,28),gtop=min(60.,gbase*g.u(1.5,3)); vector<D> grips;for(int i=0;i<ng;i++)grips.push_back(round(2*(ng==1?gbase*1.3:gbase+(gtop-gbase)*i/(ng-1)))/2);
 D gmid=(grips.front()+grips.back())/2; R.gripN0=gmid; D density=g.p(.5)?g.u(900,1300):g.u(2000,2800); R.mass=density*R.L*R.S*R.H; D mmax=2*R.muF*grips[0]/9.81/3.0; if(R.mass>mmax)R.mass=mmax*g.u(.6,1); R.mass=round(R.mass*1e4)/1e4;
 D K=g.lu(2e4,2e6);D ku=g.nc(.06,.12);R.K[0]=K*(1+ku);R.K[1]=K*(1-ku); D kn=K*g.u(1.5,4); D mixw=g.p(.5)?g.u(0,1):(g.p(.5)?1:0); D dmid=1.4*gmid/kn;
 R.ca=mixw/sqrt(dmid);R.cb=(1-mixw)/sqrt(sqrt(dmid)); R.crown=dmid*g.u(.15,.7); {D d=dmid,gg=d*(R.ca*sqrt(d)+R.cb*sqrt(sqrt(d)));for(int f=0;f<2;f++)R.Cn[f]=gmid/gg*(1+g.nc(.05,.1));}
 R.kapN=g.u(.05,.3);R.tauN=g.lu(.05,1);R.kapT=g.u(.03,.2);R.tauT=g.lu(.05,1);R.stiffexp=g.u(0,.5);R.layer=g.u(0,.5);
 {D r[3]={g.u(.3,.6),1,g.u(1.5,3)},e[3]={g.u(.25,.5),g.u(.3,.5),g.u(.1,.3)};D se=0,ss=0;for(int k=0;k<3;k++){se+=e[k];ss+=e[k]*r[k];}for(int k=0;k<3;k++){R.e[k]=e[k]/se;R.s[k]=e[k]*r[k]/ss;}}
 R.uneven=.1; for(int f=0;f<2;f++){D a=g.n(.05),b=g.n(.05),c=g.u(0,6.28);for(int i=0;i<NP;i++)R.un[f][i]=max(-.3,min(.3,g.n(.06)+(a+b)*cos(2*(2*PI*(i%16)/16)+c)*.7)); R.padtilt[f][0]=g.n(.02)*R.crown/R.rad;R.padtilt[f][1]=g.n(.02)*R.crown/R.rad; R.padoff[f]={g.nc(.005,.01)*dia,0,g.nc(.005,.01)*dia};}
 R.kj=g.lu(2e5,2e6);R.cj=R.kj*.004;{D ke=1/(1/kn+1/R.kj);R.gtau=g.u(.025,.08);R.gg=1/(R.gtau*ke);}
 R.tau_arm=g.u(.003,.012);R.rampt=g.u(.03,.12); R.Kp=g.lu(3e5,8e6);R.pexp=g.u(1,1.35);R.pt_ratio=g.u(.5,.9);R.hc=g.u(3,15);
 R.pk=g.p(.5)?0:(g.p(.5)?1:2);R.plen=min(1e-3*g.i(10,30),R.S);R.pivlen=min(1e-3*g.i(12,30),R.S);R.tipr=1e-3*g.i(2,8);
 R.psq={0,g.nc(2e-4,4e-4),g.nc(2e-4,4e-4)};
 for(int s=0;s<3;s++){R.sorg[s]={g.nc(1e-4,2e-4),g.nc(1e-4,2e-4),g.nc(1e-4,2e-4)};R.sax[s]={g.nc(2e-3,4e-3),g.nc(2e-3,4e-3),g.nc(2e-3,4e-3)};R.sgain[s]=g.nc(.0015,.003);}
 R.nf=g.lu(.006,.03);R.nfu=round(100*g.u(.12,.3))/100;R.nt=g.lu(1.5e-4,5e-4);R.ntu=round(1e4*g.u(.002,.004))/1e4;R.pf=g.lu(.015,.05);R.pfu=round(100*g.u(.25,.75))/100;R.ptq=g.lu(.8e-3,2.5e-3);R.ptu=round(1e3*g.u(.01,.04))/1e3;R.pp=g.lu(2e-5,5e-5);R.pr=g.lu(1.5e-4,5e-4);
 auto rnd=[](D x){char b[30];snprintf(b,30,"%.2g",x);return atof(b);}; R.nf=rnd(R.nf);R.nt=rnd(R.nt);R.pf=rnd(R.pf);R.ptq=rnd(R.ptq);R.pp=rnd(R.pp);R.pr=rnd(R.pr);
 for(int c=0;c<18;c++){D u=c<12?((c%6)<3?R.nfu:R.ntu):((c%6)<3?R.pfu:R.ptu);R.bias[c]=g.nc(.2*u,.5*u);R.drift[c]=g.nc(.08*u,.2*u);}
 R.frvar=g.u(.01,.04)/1.12;R.gripnoise=g.u(.0005,.002);R.gposnoise=g.lu(1e-5,5e-5);R.wander=min(8e-6,.03*R.muF*gmid/K)*g.u(.3,1);R.clock=g.u(-.45,.45)/R.fs;R.setup_p=g.u(5e-5,2e-4);R.setup_r=g.u(3e-4,1.5e-3);R.gap=round(1e4*g.u(.0004,.0011))/1e4;R.rest=g.u(.25,.6);
 // effects
 Fx E; Key ek; auto F=[&]{return ge.lu(.7,3);};
 vector<string> ekeys; 
 for(auto&id:ids){ Key k; D f=F(),f2=F(),sg=ge.sg(); 
  if(id=="static_friction"){E.st_ex=.2*f;E.st_v=.002*ge.lu(.5,2);E.st_len=ge.lu(1e-5,6e-5);k.a("excess",E.st_ex);k.a("stribeck_speed_m_s",E.st_v);k.a("length_m",E.st_len);}
  else if(id=="viscous_friction"){E.visc=2*f;k.a("viscosity_s_m",E.visc);}
  else if(id=="dwell_strengthening"){E.dw=min(.05*f,.12);E.dw_cut=ge.lu(.02,.1);E.dw_ren=ge.lu(1e-5,5e-5);k.a("strengthening",E.dw);k.a("cutoff_s",E.dw_cut);k.a("renewal_m",E.dw_ren);}
  else if(id=="load_dependent_friction"){E.ldexp=.15*f;k.a("exponent",E.ldexp);}
  else if(id=="anisotropic_friction"){E.aniso=exp(sg*log(1.4)*min(f,2.4));k.a("ratio",E.aniso);}
  else if(id=="finger_friction_mismatch"){E.mism=sg*min(.15*f,.4);k.a("mismatch",E.mism);}
  else if(id=="wear_drift"){E.wear=-.0012*f*(ge.p(.8)?1:-1);E.wear_mode=ge.i(0,1);k.a("rate_per_trial",E.wear);k.a("mode_saturating",E.wear_mode);}
  else if(id=="torsional_friction"){E.dR=sg*.002*f;E.dR=max(-.4*R.rad,E.dR);k.a("radius_change_m_patch",E.dR);}
  else if(id=="pressure_offset"){D a=ge.u(0,6.28);D r=min(.002*f,.4*R.rad);E.pox=r*cos(a);E.poz=r*sin(a);k.a("offset_x_m",E.pox);k.a("offset_z_m",E.poz);}
  else if(id=="face_tilt"){if(ge.p(.6)){E.wedge=sg*min(.01*f,.025);k.a("slope_rad",E.wedge);}else{E.mugrad=sg*6*f;k.a("friction_gradient_1_m",E.mugrad);}}
  else if(id=="face_waviness"){E.wav_l=ge.u(.006,.014);E.wav_ph=ge.u(-3,3);E.wav_h2=ge.u(-.3,.3);E.wav_h3=ge.u(-.15,.15);if(ge.p(.75)){E.wav_mu=.1*f;k.a("amplitude",E.wav_mu);}else{E.wav_mu=.06*f;E.wav_thick=.03*f*dmid;k.a("amplitude",E.wav_mu);k.a("thickness_m",E.wav_thick);}k.a("wavelength_m",E.wav_l);}
  else if(id=="plate_tilt"){int m=ge.i(0,2);D p=m!=1?sg*.01*f:0,y=m!=0?ge.sg()*.01*f2:0; if(R.pk==1){p=0;y=ge.sg()*.01*f2;} if(R.pk==2){R.pk=0;} E.pt_pitch=p;E.pt_yaw=y;k.a("pitch_rad",p);k.a("yaw_rad",y);}
  else if(id=="adhesion"){E.adh=min(1.0*f,.25*gmid);k.a("pull_off_n",E.adh);}
  else if(id=="grip_force_loss"){if(ge.p(.6)){E.gl_frac=min(.1*f,.3);k.a("fraction",E.gl_frac);}else{E.gl_off=min(1.*f,.3*grips[0]);k.a("offset_n",E.gl_off);}}
  else if(id=="grip_force_lag"){int m=ge.i(0,2);if(m==0){E.lag_drop=min(.12*f,.35);E.lag_knee=ge.lu(5e-4,3e-3);E.lag_tau=ge.lu(.03,.3);k.a("drop",E.lag_drop);k.a("knee_m_s",E.lag_knee);k.a("time_s",E.lag_tau);}else if(m==1){E.lag_slip=12*f;k.a("drop_1_m",E.lag_slip);}else{E.lag_pull=min(.2*f,.5);k.a("loss_per_pull",E.lag_pull);}}
  else if(id=="mass_error"){if(ge.p(.5)){E.m_frac=ge.p(.7)?.1*f:-.1*f;k.a("fraction",E.m_frac);}else{E.com_x=sg*min(.004*f,R.L/6);k.a("com_x_m",E.com_x);}}
  else if(id=="external_force"){V d{ge.n(),ge.n(),ge.n()};d=(.6*f/nrm(d))*d;D lim=.3*R.muF*grips[0];if(nrm(d)>lim)d=(lim/nrm(d))*d;E.ext=d;if(ge.p(.5))E.ext_k=20*f2;E.ext_at=ge.p(.5)?0:ge.u(-.3,.3)*R.L;k.a("x_n",d.x);k.a("y_n",d.y);k.a("z_n",d.z);k.a("stiffness_n_m",E.ext_k);k.a("at_x_m",E.ext_at);}
  else if(id=="gravity_tilt"){int m=ge.i(0,2);if(m!=1)E.tilt_x=sg*min(.05*f,.15);if(m!=0)E.tilt_y=ge.sg()*min(.05*f2,.15);k.a("about_x_rad",E.tilt_x);k.a("about_y_rad",E.tilt_y);}
  else if(id=="rolling_resistance"){E.roll=.001*f;k.a("arm_m",E.roll);}
  else if(id=="sensor_bias"){int n=ge.i(1,4);for(int j=0;j<n;j++){int c=ge.i(0,17);E.sb[c]=ge.sg()*((c%6)<3?.25:.003)*F()*(c>=12?2:1);k.a("ch"+to_string(c),E.sb[c]);}}
  else if(id=="sensor_gain"){int m=ge.i(0,3);for(int s=0;s<3;s++)if(m==3||m==s){E.sg[s]=ge.sg()*.05*F();k.a("s"+to_string(s),E.sg[s]);}}
  else if(id=="sensor_misalignment"){int s=ge.i(0,2);D a[3]={0,0,0};int ax=ge.i(0,2);if(s==2&&ax==0)ax=1+ge.i(0,1);if(s<2&&ax==1&&ge.p(.7))ax=2*ge.i(0,1);a[ax]=sg*.03*f;if(ge.p(.3)){int b=ge.i(0,2);if(b!=ax)a[b]=.03*f2;}E.sm[s]={a[0],a[1],a[2]};k.a("sensor",s);k.a("x_rad",a[0]);k.a("y_rad",a[1]);k.a("z_rad",a[2]);}
  else if(id=="sensor_crosstalk"){int s=ge.i(0,2);int c=ge.i(0,4);D vv=sg*(c<2?.02:.0005)*f;if(s<2){E.xt[s][c]=vv;if(ge.p(.5)){int c2=ge.i(0,4);E.xt[s][c2]=(c2<2?.02:.0005)*f2;k.a("second_"+to_string(c2),E.xt[s][c2]);}}else E.xtp[c]=vv*(c<2?1:2);k.a("sensor",s);k.a("channel",c);k.a("value",vv);}
  else if(id=="mocap_latency"){E.lat=.02*f;k.a("latency_s",E.lat);}
  else if(id=="x_clamp_slip"){E.clamp_f=R.muF*ge.u(.45,.85);k.a("limit_over_grip",E.clamp_f);}
  else if(id=="x_drive_chatter"){E.chat_l=ge.lu(1.5e-4,8e-4);E.chat_a=E.chat_l*ge.u(.4,.95);k.a("period_m",E.chat_l);k.a("amplitude_m",E.chat_a);}
  else if(id=="x_gain_drift"){int s=ge.i(0,2);E.gain_drift[s]=sg*.06*f;if(s<2&&ge.p(.4))E.gain_drift[1-s]=E.gain_drift[s]*ge.u(.5,1);k.a("sensor",s);k.a("gain_change_over_the_set",E.gain_drift[s]);}
  else if(id=="x_oil_patch"){E.oil_d=ge.u(.25,.7);E.oil_x=ge.u(-.012,.0);E.oil_z=ge.u(-.003,.003);E.oil_r=ge.u(.4,.9)*R.rad;k.a("depth",E.oil_d);k.a("x_m",E.oil_x);k.a("z_m",E.oil_z);k.a("radius_m",E.oil_r);}
  else if(id=="x_object_flex"){E.flex_b=ge.lu(2e-3,1.2e-2);E.flex_a=ge.lu(2e-6,1.5e-5);k.a("bend_rad_nm",E.flex_b);k.a("axial_m_n",E.flex_a);}
  else if(id=="x_heating"){D fr=ge.u(.08,.3);E.heat=fr/(2*R.muF*gmid*.008);k.a("fall_1_J",E.heat);}
  ekeys.push_back("{\"id\": \""+id+"\", \"params\": "+k.str()+"}"); }
 // plan
 bool plane=R.pk==0; bool needpiv=has("rolling_resistance"); D pivshare=needpiv?gp.u(.3,.6):(gp.p(.45)?gp.u(.2,.5):0);
 R.rep=gp.i(2,3); int ncmin=max(8,(24+R.rep-1)/R.rep),ncmax=min(30,60/R.rep); int nc=gp.i(ncmin,ncmax);
 vector<vector<D>> sl={{0},{0},{0,.1745},{-.1745,.1745},{-.349,-.1745,0,.1745,.349},{-.2618,0,.2618},{0,.0873,.1745}};
 vector<D> slopes=sl[gp.i(has("anisotropic_friction")?2:0,6)]; int nsv=gp.i(1,3); if(has("viscous_friction")||has("static_friction"))nsv=3; D v0=gp.lu(.004,.012); vector<D> speeds;for(int i=0;i<nsv;i++)speeds.push_back(rnd(min(.03,v0*pow(gp.p(.5)?2:1.6,i))));
 vector<D> offs={0}; if(!plane&&gp.p(.6)){D o=rnd(.3*R.rad*gp.u(.5,1));offs={0,o};if(gp.p(.5))offs.push_back(-o);} vector<D> pauses={0}; if(gp.p(.4))pauses={0,rnd(gp.u(.3,1.2))}; 
 D mu0=R.muF*(1+E.st_ex)*(1+3*E.dw); D brk=mu0*grips.back()/K*R.s[2]/R.e[2]; D dist=max(gp.u(.006,.012),min(.016,brk*1.8+.003)); dist=min(dist,R.L/2-R.rad*1.1); bool slowcap=true;(void)slowcap;
 vector<D> prs={};int npr=gp.i(1,2);D w0=gp.lu(.08,.2);for(int i=0;i<npr;i++)prs.push_back(rnd(w0*pow(2.2,i)));vector<D> poffs={0}; if(gp.p(.6))poffs={0,rnd(R.L*.12)}; D pang=gp.u(.3,.5);
 {int np0=nc-(int)min((D)(grips.size()*prs.size()*poffs.size()),round(nc*pivshare));auto prod=[&]{return (int)(grips.size()*speeds.size()*slopes.size()*offs.size()*pauses.size());};
  while(prod()<np0){int w=gp.i(0,2); if(w==0&&grips.size()<7){D x=round(2*(gbase+(gtop-gbase)*gp.u()))/2;if(find(grips.begin(),grips.end(),x)==grips.end())grips.push_back(x);}else if(w==1&&speeds.size()<4){D x=rnd(gp.lu(.004,.03));if(find(speeds.begin(),speeds.end(),x)==speeds.end())speeds.push_back(x);}else if(w==2&&slopes.size()<5){D x=slopes[0]==0&&slopes.size()==1?.1745:(slopes.back()>0&&find(slopes.begin(),slopes.end(),-slopes.back())==slopes.end()?-slopes.back():slopes.back()+.0873);if(fabs(x)<.4&&find(slopes.begin(),slopes.end(),x)==slopes.end())slopes.push_back(x);} }}
 vector<Cond> push,piv; for(D a:grips)for(D b:speeds)for(D c:slopes)for(D o:offs)for(D p:pauses){D d=dist;if(d/b>2.2)d=max(2.2*b,min(dist,.5*dist+1.1*b));push.push_back({0,a,b,c,o,p,d,0,0});}
 for(D a:grips)for(D b:prs)for(D o:poffs)piv.push_back({1,a,b,0,o,0,min(pang,2.2*b),0,0});
 for(auto&c:piv)if(c.dist<.2)c.dist=.2;
 shuffle(push.begin(),push.end(),gp.g);shuffle(piv.begin(),piv.end(),gp.g); int np=(int)round(nc*pivshare); if((int)piv.size()>np)piv.resize(np); int nl=nc-(int)piv.size();
 while((int)push.size()<nl&&true){ // finer levels, until there are enough conditions
  vector<Cond> add;for(auto&c:push){Cond d=c;if(gp.p(.5))d.grip=round(2*max(8.,min(60.,c.grip*gp.u(.8,1.35))))/2;else d.speed=rnd(max(.004,min(.03,c.speed*gp.u(.5,1.8))));if(d.dist/d.speed>2.5)d.dist=2.5*d.speed;bool dup=false;for(auto&o:push)if(o.grip==d.grip&&o.speed==d.speed&&o.slope==d.slope&&o.off==d.off&&o.pause==d.pause)dup=true;if(!dup)add.push_back(d);if(d.grip<grips[0])d.grip=grips[0];} for(auto&d:add)if((int)push.size()<nl)push.push_back(d); }
 push.resize(nl); auto cmp=[](const Cond&a,const Cond&b){return tie(a.kind,a.grip,a.speed,a.slope,a.off,a.pause)<tie(b.kind,b.grip,b.speed,b.slope,b.off,b.pause);}; vector<Cond> all=push;all.insert(all.end(),piv.begin(),piv.end()); int order=gp.i(0,2); // 0 by condition, 1 shuffled, 2 blocks of repetitions
 sort(all.begin(),all.end(),cmp); vector<Cond> tr;for(size_t i=0;i<all.size();i++)all[i].id=i; if(order==0){for(auto c:all)for(int r=0;r<R.rep;r++){c.run=r;tr.push_back(c);}}else{for(int r=0;r<R.rep;r++){auto b=all;shuffle(b.begin(),b.end(),gp.g);for(auto c:b){c.run=r;tr.push_back(c);}}if(order==1)shuffle(tr.begin(),tr.end(),gp.g);}
 // a repetition's number by order of time
 {map<int,int> cnt;for(auto&c:tr)c.run=cnt[c.id]++;}
 bool anypush=nl>0,anypiv=!piv.empty(); bool anypause=false;for(auto&c:tr)anypause|=c.pause>0;
 filesystem::create_directories(dir+"/trials");
 {ofstream o(dir+"/dataset.toml");o<<"format = \"stickslip-dataset/1\"\nname = \"set"<<number<<"\"\nsample_rate_hz = "<<js(R.fs)<<"\ngravity_m_s2 = [0.0, 0.0, -9.81]\n\n[[objects]]\nid = \"bar\"\nshape = \""<<(R.S==R.H?"prism":"polygon")<<"\"\n";
  if(R.S==R.H)o<<"length_m = "<<js(R.L)<<"\nside_m = "<<js(R.S)<<"\n";else {D a=R.L/2,b=R.S/2;o<<"vertices_m = [["<<js(-a)<<", "<<js(-b)<<"], ["<<js(a)<<", "<<js(-b)<<"], ["<<js(a)<<", "<<js(b)<<"], ["<<js(-a)<<", "<<js(b)<<"]]\nheight_m = "<<js(R.H)<<"\n";}
  auto fl=[](D x){string s=js(x);if(s.find('.')==string::npos&&s.find('e')==string::npos)s+=".0";return s;};
  o<<"mass_kg = "<<js(R.mass)<<"\n\n[fingers]\ncontact = \"disc\"\ndiameter_m = "<<js(2*R.rad)<<"\n"; if(anypush){o<<"\n[pushers.linear_push]\n";if(R.pk==0)o<<"contact = \"plane\"\n";else if(R.pk==1)o<<"contact = \"line\"\nlength_m = "<<js(R.plen)<<"\n";else o<<"contact = \"point\"\ntip_radius_m = "<<js(R.tipr)<<"\n";} if(anypiv)o<<"\n[pushers.pivot]\ncontact = \"line\"\nlength_m = "<<js(R.pivlen)<<"\n";
  o<<"\n[sensors.finger]\nforce_noise_n = "<<fl(R.nf)<<"\nforce_uncertainty_n = "<<fl(R.nfu)<<"\ntorque_noise_nm = "<<fl(R.nt)<<"\ntorque_uncertainty_nm = "<<fl(R.ntu)<<"\n\n[sensors.pusher]\nforce_noise_n = "<<fl(R.pf)<<"\nforce_uncertainty_n = "<<fl(R.pfu)<<"\ntorque_noise_nm = "<<fl(R.ptq)<<"\ntorque_uncertainty_nm = "<<fl(R.ptu)<<"\n\n[sensors.pose]\nposition_noise_m = "<<fl(R.pp)<<"\nrotation_noise_rad = "<<fl(R.pr)<<"\n";}
 FILE*tc=fopen((dir+"/trials.csv").c_str(),"w"); fprintf(tc,"trial,file,object,primitive,grip_n,speed_m_s,speed_rad_s,slope_rad,pusher_offset_m,run,%spusher_x_m,pusher_y_m,pusher_z_m,pusher_qw,pusher_qx,pusher_qy,pusher_qz\n",anypause?"pause_s,":"");
 if(clean){R.gripnoise=0;} Stat st; vector<Samp> S; size_t ntr=tr.size(); size_t kmax=ntr; if(getenv("SIM7_MAX"))kmax=min(ntr,(size_t)atol(getenv("SIM7_MAX")));
 for(size_t k=0;k<kmax;k++){ Cond c=tr[k]; D wf=1;if(E.wear!=0)wf=E.wear_mode==0?1+E.wear*k:1+E.wear*ntr*.8*(1-exp(-2.*k/ntr)); D slipw=0; simulate(R,E,c,wf,0,seed*1000+k,scale,S,st,slipw);
  bool pv=c.kind==1;int pk=pv?1:R.pk; V Po;Q Pq;if(pv){Po={-(R.L/2-.005)+c.off,0,-(R.H/2+R.gap)};Pq=rv({0,-PI/2,0});}else Po={-(R.L/2+R.gap)-(pk==2?R.tipr:0),0,pk==0?0:c.off};
  char fn[64];snprintf(fn,64,"trials/t%04zu.csv",k); fprintf(tc,"t%04zu,%s,bar,%s,%g,",k,fn,pv?"pivot":"linear_push",c.grip); if(pv)fprintf(tc,",%g,,%g,%d,",c.speed,c.off,c.run);else{fprintf(tc,"%g,,%.6g,",c.speed,c.slope);if(pk!=0)fprintf(tc,"%g",c.off);fprintf(tc,",%d,",c.run);} if(anypause)fprintf(tc,"%g,",c.pause); fprintf(tc,"%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g\n",Po.x,Po.y,Po.z,Pq.w,Pq.x,Pq.y,Pq.z);
  FILE*o=fopen((dir+"/"+fn).c_str(),"w"); fputs("t_s,grip_cmd_n,gripper_x_m,gripper_y_m,gripper_z_m,gripper_qw,gripper_qx,gripper_qy,gripper_qz,object_x_m,object_y_m,object_z_m,object_qw,object_qx,object_qy,object_qz",o); for(auto s:{"finger1","finger2","pusher"})fprintf(o,",%s_fx_n,%s_fy_n,%s_fz_n,%s_tx_nm,%s_ty_nm,%s_tz_nm",s,s,s,s,s,s);fputc('\n',o);
  Rng gn(seed*7919+k+5); D frac=ntr>1?(D)k/(ntr-1):0; D nf=clean?0:1;
  for(size_t i=0;i<S.size();i++){ Samp&s=S[i]; auto objat=[&](D tt,V&p,Q&q){D x=tt*R.fs;if(x<0)x=0;size_t a=(size_t)x;if(a>=S.size()-1){p=S.back().op;q=S.back().oq;return;}D f=x-a;p=(1-f)*S[a].op+f*S[a+1].op;Q A=S[a].oq,B=S[a+1].oq;q=nq({A.w+(B.w-A.w)*f,A.x+(B.x-A.x)*f,A.y+(B.y-A.y)*f,A.z+(B.z-A.z)*f});};
   V op;Q oq;objat(s.t-E.lat-nf*R.clock,op,oq); auto N=[&](D sd){return nf*gn.n(sd);}; op=op+V{N(R.pp),N(R.pp),N(R.pp)};oq=nq(mul(rv({N(R.pr),N(R.pr),N(R.pr)}),oq)); V gpz=s.gp+V{N(R.gposnoise),N(R.gposnoise),N(R.gposnoise)};
   fprintf(o,"%.6g,%g,%.7g,%.7g,%.7g,%.9g,%.7g,%.7g,%.7g,%.7g,%.7g,%.7g,%.9g,%.7g,%.7g,%.7g",s.t,c.grip,gpz.x,gpz.y,gpz.z,s.gq.w,s.gq.x,s.gq.y,s.gq.z,op.x,op.y,op.z,oq.w,oq.x,oq.y,oq.z);
   for(int q=0;q<3;q++){ V F=s.F[q],T=s.T[q]; T=T+cross(nf*R.sorg[q],F); Q al=mul(rv(E.sm[q]),rv(nf*R.sax[q])); F=rot(al,F);T=rot(al,T); D gain=(1+nf*R.sgain[q])*(1+E.sg[q])*(1+E.gain_drift[q]*frac); F=gain*F;T=gain*T;
    if(q<2){D y=F.y;F.x+=E.xt[q][0]*y;F.z+=E.xt[q][1]*y;T=T+y*V{E.xt[q][2],E.xt[q][3],E.xt[q][4]};}else{D x=F.x;F.y+=E.xtp[0]*x;F.z+=E.xtp[1]*x;T=T+x*V{E.xtp[2],E.xtp[3],E.xtp[4]};}
    D val[6]={F.x,F.y,F.z,T.x,T.y,T.z}; for(int j=0;j<6;j++){int ch=q*6+j;D sd=q<2?(j<3?R.nf:R.nt):(j<3?R.pf:R.ptq);fprintf(o,",%.7g",val[j]+E.sb[ch]+nf*(R.bias[ch]+R.drift[ch]*(2*frac-1))+N(sd));} }
   fputc('\n',o);} fclose(o); }
 fclose(tc);
 fprintf(stderr,"trials %zu conds %zu fs %g rows(last) %zu pusher %d | balance residual max %.2e rms %.2e N | friction over muN max %.2e | steady |F/muN-1| max %.2e (%ld steps) | Newton its/step %.2f\n",ntr,all.size(),R.fs,S.size(),R.pk,st.bal,sqrt(st.balrms/max(1L,st.nb)),st.over,st.steady,st.ns,(D)st.it/st.steps);
 Key k;k.a("number",number);k.a("seed",(D)seed); {string a="[";for(size_t i=0;i<ekeys.size();i++)a+=(i?", ":"")+ekeys[i];k.r("effects",a+"]");} k.a("mu_finger",R.muF);k.a("mu_pusher",R.muP);k.a("mu_finger1",R.mF[0]);k.a("mu_finger2",R.mF[1]);k.a("mass_stated_kg",R.mass);
 k.a("pad_tangential_n_m",K);k.a("pad1_tangential_n_m",R.K[0]);k.a("pad2_tangential_n_m",R.K[1]);k.a("pad_normal_n_m",kn);k.a("jaw_n_m",R.kj);k.a("pusher_normal_n_m",R.Kp);k.a("pusher_tangential_ratio",R.pt_ratio);k.a("stiffening_exponent",R.stiffexp);k.a("zener_tangential",R.kapT);k.a("zener_time_s",R.tauT);k.a("reference_grip_n",R.gripN0);k.a("crown_over_compression",R.crown/dmid);
 k.a("friction_variation",R.frvar*1.12);k.a("grip_loop_s",R.gtau);k.a("arm_lag_s",R.tau_arm);k.a("arm_wander_m",R.wander);k.a("gripper_pose_noise_m",R.gposnoise);k.a("clock_offset_s",R.clock);k.a("plate_pitch_everyday_rad",R.psq.y);k.a("plate_yaw_everyday_rad",R.psq.z);
 auto arr=[](const D*p,int n){string a="[";for(int i=0;i<n;i++)a+=(i?", ":"")+js(p[i]);return a+"]";}; k.r("bias_18",arr(R.bias,18));k.r("drift_18",arr(R.drift,18));k.r("gain_errors",arr(R.sgain,3)); for(int f=0;f<2;f++){D a[2]={R.padoff[f].x,R.padoff[f].z};k.r("pad_offset_"+to_string(f+1),arr(a,2));} for(int q=0;q<3;q++){D a[6]={R.sax[q].x,R.sax[q].y,R.sax[q].z,R.sorg[q].x,R.sorg[q].y,R.sorg[q].z};k.r("sensor_axes_origin_"+to_string(q+1),arr(a,6));}
 k.a("trials",ntr);k.a("conditions",all.size());k.a("pusher_kind",R.pk); ofstream(argv[5])<<k.str()<<"\n"; return 0; }
