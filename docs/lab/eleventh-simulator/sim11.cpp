// sim11: independent fine-step compliant simulator of prehensile pushing (6 DoF object, explicit steps).
// Pads: 18 elements each, normal power law (Hertz-like exponent 1, 1.25 or 1.5) with Hunt-Crossley damping; tangential
// standard-linear-solid (spring + Maxwell branch + dashpot) behind a Bouc-Wen-like slider (exponent n).  Plate: 16 such elements
// at the object's end face; edge: 9 elements along the line.  Jaw: one force-controlled opening coordinate with mass.
// ./sim11 NUMBER SEED EFFECTS FOLDER KEY.json [dt_divisor [only_trial]]
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>
#include <array>
#include <map>
#include <set>
#include <tuple>
#include <random>
#include <algorithm>
#include <filesystem>
using namespace std;
typedef double D;
struct V{D x=0,y=0,z=0;};
static inline V operator+(V a,V b){return{a.x+b.x,a.y+b.y,a.z+b.z};}
static inline V operator-(V a,V b){return{a.x-b.x,a.y-b.y,a.z-b.z};}
static inline V operator*(V a,D s){return{a.x*s,a.y*s,a.z*s};}
static inline D dot(V a,V b){return a.x*b.x+a.y*b.y+a.z*b.z;}
static inline V cross(V a,V b){return{a.y*b.z-a.z*b.y,a.z*b.x-a.x*b.z,a.x*b.y-a.y*b.x};}
struct Q{D w=1,x=0,y=0,z=0;};
static inline Q qmul(Q a,Q b){return{a.w*b.w-a.x*b.x-a.y*b.y-a.z*b.z,a.w*b.x+a.x*b.w+a.y*b.z-a.z*b.y,a.w*b.y-a.x*b.z+a.y*b.w+a.z*b.x,a.w*b.z+a.x*b.y-a.y*b.x+a.z*b.w};}
static Q qaa(V ax,D th){D s=sin(th/2);return{cos(th/2),ax.x*s,ax.y*s,ax.z*s};}
static inline void qnorm(Q&q){D n=1/sqrt(q.w*q.w+q.x*q.x+q.y*q.y+q.z*q.z);q.w*=n;q.x*=n;q.y*=n;q.z*=n;}
struct M{V a,b,c;}; // columns: images of x,y,z
static inline M qmat(Q q){M m;m.a={1-2*(q.y*q.y+q.z*q.z),2*(q.x*q.y+q.w*q.z),2*(q.x*q.z-q.w*q.y)};
 m.b={2*(q.x*q.y-q.w*q.z),1-2*(q.x*q.x+q.z*q.z),2*(q.y*q.z+q.w*q.x)};m.c={2*(q.x*q.z+q.w*q.y),2*(q.y*q.z-q.w*q.x),1-2*(q.x*q.x+q.y*q.y)};return m;}
static inline V mul(const M&m,V v){return m.a*v.x+m.b*v.y+m.c*v.z;}
static inline V tmul(const M&m,V v){return{dot(m.a,v),dot(m.b,v),dot(m.c,v)};}
struct Rng{mt19937_64 g;D u(){return (g()>>11)*(1.0/9007199254740992.0);}D U(D a,D b){return a+(b-a)*u();}D L(D a,D b){return exp(U(log(a),log(b)));}
 D n(){D a=u()+1e-300,b=u();return sqrt(-2*log(a))*cos(2*M_PI*b);}int I(int a,int b){return a+int(u()*(b-a+1));}D sg(){return u()<.5?-1:1;}};
static Rng R;
typedef map<string,D> P;
struct Eff{string id;P p;};
static vector<Eff> effs;
static map<string,D> E; // flat "id.param"
static D e(const char*k){auto i=E.find(k);return i==E.end()?0:i->second;}
// ---- set parameters
struct Set{
 D hx,side,dia,mu_f,mu_p,Kt,Kn,Kp,Kpt,Nref,pN,stif,gamma,kmr,tau,zeta,pP,kmrp,taup,jawM,jawZ; int nbw,nbwp;
 D yaw,pitch; D sF,sT,sPf,sPt,sPos,sRot; D bF[2][6],bP[6]; D rep;
 vector<D> mass;
} S;
struct Cond{string prim;int obj;D grip,v,w,slope,poff,x0,rest,pause,gap;int run;D travel,acc;};
struct El{D zx=0,zy=0,mx=0,my=0,vs=0,th=0;};
struct FricP{D ex=0,vst=.002,vis=0,str=0,cut=.05,L=2e-5;bool any=false;};
static FricP fF,fP;
// tangential law: v velocity of object relative to body, in 2 axes; returns force on object in fx,fy
static inline void tang(El&s,D vx,D vy,D dt,D k,D km,D tau,D c,D N,D mu,D Nextra,int n,const FricP&f,D sr,D&fx,D&fy){
 if(f.any){D g=1; if(f.ex!=0)g+=f.ex*exp(-s.vs/f.vst); if(f.str!=0)g*=1+f.str*log(1+s.th/f.cut); mu=mu*g+f.vis*s.vs; if(mu<.01)mu=.01;}
 D lim=mu*(N+Nextra); D isr=1/sr;
 D Fx=k*s.zx+s.mx,Fy=k*s.zy+s.my; D gx=Fx*isr,gy=Fy*sr; D gg=sqrt(gx*gx+gy*gy); D pl=0,ax=vx,ay=vy;
 if(gg>1e-15){D r=gg/lim;if(r>1)r=1;D dx=gx*isr,dy=gy*sr,dn=1/sqrt(dx*dx+dy*dy);dx*=dn;dy*=dn;D vn=vx*dx+vy*dy;
  if(vn>0){D a=r;for(int i=1;i<n;i++)a*=r;pl=a*vn;ax-=pl*dx;ay-=pl*dy;}}
 s.zx+=ax*dt;s.zy+=ay*dt;s.mx+=km*ax*dt-s.mx*dt/tau;s.my+=km*ay*dt-s.my*dt/tau;
 Fx=k*s.zx+s.mx;Fy=k*s.zy+s.my;gx=Fx*isr;gy=Fy*sr;gg=sqrt(gx*gx+gy*gy);
 if(gg>lim){D q=lim/gg;s.zx*=q;s.zy*=q;s.mx*=q;s.my*=q;Fx*=q;Fy*=q;}
 if(f.any){s.vs+=(pl-s.vs)*dt/1e-3;s.th+=dt*(1-s.vs*s.th/f.L);if(s.th<0)s.th=0;}
 fx=-(Fx+c*ax);fy=-(Fy+c*ay);
}
static inline D powp(D r,int code){D q=sqrt(r);return code==0?r:code==1?r*sqrt(q):r*q;} // 1, 1.25, 1.5
static D pexp(int c){return c==0?1:c==1?1.25:1.5;}
static int cN,cS,cP; // codes

struct Rec{V gp;Q gq;V op;Q oq;V f1,t1,f2,t2,pf,pt;D t;};
static vector<array<D,3>> padEl; // x,z,w
static D motionS(const Cond&c,D t,D&vel,D vmax,D total){ // smooth trapezoid with optional pause at half way
 auto prof=[&](D tt,D len,D&v){D Ta=c.acc;D T=len/vmax; // accel phase Ta, total duration T+Ta
  if(tt<=0){v=0;return 0.0;} if(tt>=T+Ta){v=0;return len;}
  auto ramp=[&](D x,D&vv){ // integral of smoothstep velocity
    D q=x/Ta; if(q>=1){vv=1;return x-Ta/2;} vv=q*q*(3-2*q); return Ta*(q*q*q-q*q*q*q/2);};
  D va,vb=0;D a=ramp(tt,va),b=0;if(tt>T)b=ramp(tt-T,vb);v=vmax*(va-vb);return vmax*(a-b);};
 if(c.pause<=0)return prof(t,total,vel);
 D h=total/2;D T1=h/vmax+c.acc;D v1,v2;D s1=prof(t,h,v1),s2=prof(t-T1-c.pause,h,v2);vel=v1+v2;return s1+s2;}
static D sc(D x,D half){ D d=half-fabs(x); if(d<=-2.5e-4)return 0; if(d>=2.5e-4)return 1; return (d+2.5e-4)/5e-4; }
static void simulate(const Cond&c,int idx,D dt,D mff,D mfp,const D*mf12,D gripF,D gapErr,D dayGrip,vector<Rec>&out){
 D m=S.mass[c.obj]*(1+e("mass_error.fraction")); D comx=e("mass_error.com_x_m");
 D hx=S.hx,hy=S.side/2; D Ix=m*S.side*S.side/6,Iy=m*(4*hx*hx+S.side*S.side)/12;
 bool lin=c.prim=="linear_push",piv=c.prim=="pivot";
 D tx=e("gravity_tilt.about_x_rad"),ty=e("gravity_tilt.about_y_rad");
 V g=mul(qmat(qmul(qaa({1,0,0},tx),qaa({0,1,0},ty))),V{0,0,-9.81});
 V ext={e("external_force.x_n"),e("external_force.y_n"),e("external_force.z_n")};
 // state
 V po={c.x0,0,0},vo,wo;Q qo;D d,dv=0;
 D d0=pexp(cN)*S.Nref/S.Kn; D F0=c.grip; d=d0*pow(F0/S.Nref,1/pexp(cN));
 D lossF=0,slipAcc=0;
 vector<El> e1(padEl.size()),e2(padEl.size());for(auto&x:e1)x.th=c.rest;for(auto&x:e2)x.th=c.rest;
 // plate elements
 struct PE{D y,z,w;};vector<PE> pe;D pts[4]={-hy,-hy*.36,hy*.36,hy};D pw[4]={.18,.32,.32,.18};
 for(int i=0;i<4;i++)for(int j=0;j<4;j++)pe.push_back({pts[i],pts[j],pw[i]*pw[j]});
 vector<PE> le;D ll=.028;for(int i=0;i<9;i++)le.push_back({-ll/2+ll*i/8.0,0,(i==0||i==8)?.0625:.125});
 vector<El> pes(16),les(9);for(auto&x:pes)x.th=1;for(auto&x:les)x.th=1;
 V P0; M Rp; if(lin)P0={c.x0-hx-c.gap,c.poff,0}; if(piv)P0={c.x0-hx+.005+c.poff,0,-hy-c.gap};
 V Pt=P0; // true place
 if(lin){Pt.x-=gapErr;Rp=qmat(qmul(qaa({0,1,0},S.pitch+e("plate_tilt.pitch_rad")),qaa({0,0,1},S.yaw+e("plate_tilt.yaw_rad"))));}
 if(piv){Pt.z-=gapErr;Rp=qmat(qmul(qaa({0,1,0},-M_PI/2),qaa({0,0,1},e("plate_tilt.line_rad"))));}
 D Pref=30; D pd0=pexp(cP)*Pref/S.Kp;
 // damping
 D cPad=S.zeta*sqrt(2*S.Kt*m), cPl=S.zeta*sqrt(S.Kpt*m)*.5, jc=2*S.jawZ*sqrt(S.jawM*S.Kn);
 D hcN=2*S.zeta*sqrt(2*S.Kn*m)/2/S.Nref; // Hunt-Crossley: N(1+a v)
 D hcP=2*S.zeta*sqrt(S.Kp*m)/Pref*.5;
 D settle=.3; D vmax=piv?c.w:c.v; D dur=c.travel/vmax+c.acc+(c.pause>0?c.pause+c.acc:0); D tend=c.rest+dur+.28;
 long nS=lround(settle/dt),nT=lround(tend/dt); int per=int(lround(.004/dt));
 D sr=e("anisotropic_friction.ratio"); sr=sr>0?pow(sr,.25):1; // limit along x: mu*sr^2 ... scaled radius: Fx/s^.. see below
 sr=sr*sr; // Fx/sr and Fz*sr on a circle: mu_x/mu_z = sr^2 = ratio
 D mm=e("finger_friction_mismatch.mismatch"),wear=1+e("wear_drift.rate_per_trial")*idx;
 D ldx=e("load_dependent_friction.exponent"); D padN[2]={F0,F0},plN=Pref; bool ldElse=e("load_dependent_friction.elsewhere")>0;
 D slope=e("face_tilt.slope_rad"),fg=e("face_tilt.friction_gradient_1_m"),gg1=e("face_tilt.grip_gradient_1_m");
 D wa=e("face_waviness.amplitude"),wl=e("face_waviness.wavelength_m"),wp=e("face_waviness.phase_rad");
 D pull=e("adhesion.pull_off_n");
 D glF=e("grip_force_loss.fraction"),glO=e("grip_force_loss.offset_n");
 D drop=e("grip_force_lag.drop"),gtau=e("grip_force_lag.time_s"),knee=e("grip_force_lag.knee_m_s"),d1=e("grip_force_lag.drop_1_m");
 bool magnet=e("unlisted:magnetic_plate.force_n")>0;D mgF=e("unlisted:magnetic_plate.force_n"),mgD=e("unlisted:magnetic_plate.range_m");
 D play=e("unlisted:loose_pusher.play_m"),playK=e("unlisted:loose_pusher.spring_n_m");
 D tcF=e("unlisted:third_contact.force_n"),tcA=e("unlisted:third_contact.from_m"),tcB=e("unlisted:third_contact.to_m"),tcM=e("unlisted:third_contact.friction");
 V uP,uPv;D uM=.25; // loose pusher
 out.clear();
 for(long k=-nS;k<=nT;k++){
  D t=k*dt;D vel=0,s=0;if(t>c.rest)s=motionS(c,t-c.rest,vel,vmax,c.travel);
  V pg,vg,wg;Q gq;M G;G.a={1,0,0};G.b={0,1,0};G.c={0,0,1};
  if(lin){V dir={-cos(c.slope),0,sin(c.slope)};pg=dir*s;vg=dir*vel;}
  else if(piv){gq=qaa({0,1,0},-s);G=qmat(gq);wg={0,-vel,0};}
  else {pg={0,0,s};vg={0,0,vel};}
  M O=qmat(qo);
  // gravity and the like
  V F=g*m+ext,T=cross(mul(O,V{comx,0,0}),g*m); if(E.count("external_force.at_x_m"))T=T+cross(mul(O,V{e("external_force.at_x_m"),0,0}),ext);
  V rel=tmul(G,po-pg); V pgo=tmul(O,pg-po); // pad middle along the object
  D fac=1;if(wa!=0)fac*=1+wa*sin(2*M_PI*pgo.x/wl+wp);
  // relative angle (about gripper y) of object X in gripper axes
  V xo=tmul(G,O.a);D cr=1,si=0;if(sr!=1){D h=1/sqrt(xo.x*xo.x+xo.z*xo.z);cr=xo.x*h;si=xo.z*h;}
  D jawN=0;V f1,t1,f2,t2,pf,pt;D slipv=0;
  for(int fi=0;fi<2;fi++){
   D sg=fi?-1:1;vector<El>&es=fi?e2:e1;V ft,tt;D Nt=0;
   D mub=S.mu_f*mff*mf12[fi]*wear*(1+sg*mm)*fac; if(ldx!=0)mub*=pow(max(padN[fi],.5)/S.Nref,-ldx);
   for(size_t i=0;i<padEl.size();i++){
    D ex=padEl[i][0],ez=padEl[i][1],w=padEl[i][2];
    V pgf={ex,sg*(hy-d),ez};V p=pg+mul(G,pgf);V r=p-po;V q=tmul(O,r);
    D del=hy+slope*q.x-sg*q.y; D cov=sc(q.x,hx)*sc(q.z,hy); El&st=es[i];
    if(del<=0||cov<=0){st.zx=st.zy=st.mx=st.my=0;st.vs=0;continue;}
    V v=vo+cross(wo,r)-vg-cross(wg,p-pg);V vgf=tmul(G,v);
    D deld=sg*vgf.y+dv; D N0=w*cov*S.Nref*powp(del/d0,cN); D N=N0*(1+max(-.9,hcN*deld)); 
    D rk=N/(w*S.Nref);D kk=w*S.Kt*(cS==0?1:cS==1?sqrt(sqrt(rk)):sqrt(rk)); if(kk<1e-3*w*S.Kt)kk=1e-3*w*S.Kt;
    D mu=mub;if(fg!=0)mu*=1+fg*q.x;
    D fx,fz; D vx=vgf.x,vz=vgf.z; D vxr=vx*cr+vz*si,vzr=-vx*si+vz*cr;
    tang(st,vxr,vzr,dt,kk,kk*S.kmr,S.tau,w*cPad,N,mu,w*pull,S.nbw,fF,sr,fx,fz);
    D gx=fx*cr-fz*si,gz=fx*si+fz*cr;
    V fg3={gx,-sg*N,gz}; if(slope!=0){fg3.x+=N*slope*xo.x;fg3.z+=N*slope*xo.z;}
    Nt+=N;ft=ft+fg3;tt=tt+cross(pgf-V{0,sg*hy,0},fg3);
    V fw=mul(G,fg3);F=F+fw;T=T+cross(r,fw);
   }
   padN[fi]=Nt;jawN+=Nt/2;if(fi){f2=ft;t2=tt;}else{f1=ft;t1=tt;}
  }
  {V r=pg-po;V v=vo+cross(wo,r)-vg;V a=tmul(G,v);slipv=sqrt(a.x*a.x+a.z*a.z)+fabs(dot(wo-wg,G.b))*.667*S.dia/2;}
  if(lin){
   V n=Rp.a;D Nt=0;V base=Pt-uP; M Rq=Rp;
   D mup=S.mu_p*mfp;if(ldElse)mup*=pow(max(plN,.5)/Pref,-ldx);
   for(int i=0;i<16;i++){V r=mul(O,V{-hx,pe[i].y,pe[i].z});V p=po+r;D del=-dot(p-base,n);El&st=pes[i];
    if(del<=0){st.zx=st.zy=st.mx=st.my=0;st.vs=0;continue;}
    V v=vo+cross(wo,r)+uPv;D deld=-dot(v,n);D w=pe[i].w;D N=w*Pref*powp(del/pd0,cP)*(1+max(-.9,hcP*deld));
    D fa,fb;D kk=w*S.Kpt;tang(st,dot(v,Rq.b),dot(v,Rq.c),dt,kk,kk*S.kmrp,S.taup,w*cPl,N,mup,0,S.nbwp,fP,1,fa,fb);
    V f=n*N+Rq.b*fa+Rq.c*fb;Nt+=N;pf=pf+f;pt=pt+cross(p-P0,f);F=F+f;T=T+cross(r,f);}
   plN=Nt;
   if(play>0){ // pusher free within +-play along x (away) and z, weak spring; beyond it the stop
    V fc=pf*-1.0; // force on the pusher
    auto ax=[&](D u,D uv,D lo,D hi,D f){D a=f-playK*u-25*uv;D Ks=S.Kp;D cs=2*.3*sqrt(Ks*uM);if(u>hi)a-=Ks*(u-hi)+cs*uv;if(u<lo)a-=Ks*(u-lo)+cs*uv;return a/uM;};
    D ax1=ax(uP.x,uPv.x,0,play,-fc.x),az=ax(uP.z,uPv.z,-play/2,play/2,-fc.z); // u is minus displacement
    uPv.x+=ax1*dt;uPv.z+=az*dt;uP.x+=uPv.x*dt;uP.z+=uPv.z*dt;}
   if(magnet){V r=mul(O,V{-hx,0,0});V p=po+r;D gap=max(0.,dot(p-Pt,n));D q=1+gap/mgD;V f=n*(-mgF/(q*q));pf=pf+f;pt=pt+cross(p-P0,f);F=F+f;T=T+cross(r,f);}
  }
  if(piv){
   V n=O.c;D Nt=0;D mup=S.mu_p*mfp;if(ldElse)mup*=pow(max(plN,.5)/Pref,-ldx);
   for(int i=0;i<9;i++){V p=Pt+mul(Rp,V{0,le[i].y,0});V r=p-po;V q=tmul(O,r);D del=q.z+hy;D cov=sc(q.x,hx)*sc(q.y,hy);El&st=les[i];
    if(del<=0||cov<=0){st.zx=st.zy=st.mx=st.my=0;st.vs=0;continue;}
    V v=vo+cross(wo,r);D deld=-dot(v,n);D w=le[i].w;D N=cov*w*Pref*powp(del/pd0,cP)*(1+max(-.9,hcP*deld));
    D fa,fb;D kk=w*S.Kpt;tang(st,dot(v,O.a),dot(v,O.b),dt,kk,kk*S.kmrp,S.taup,w*cPl,N,mup,0,S.nbwp,fP,1,fa,fb);
    V f=n*N+O.a*fa+O.b*fb;Nt+=N;pf=pf+f;pt=pt+cross(p-P0,f);F=F+f;T=T+cross(r,f);}
   plN=Nt;
  }
  if(tcF>0){D sl=rel.x-c.x0;D wdt=.0008;auto ss=[&](D x){x=x/wdt;if(x<=0)return 0.;if(x>=1)return 1.;return x*x*(3-2*x);};
   D N=tcF*ss(sl-tcA)*(1-ss(sl-tcB));if(N>0){V p=pg+mul(G,V{0,0,hy});V r=p-po;V v=tmul(G,vo+cross(wo,r)-vg-cross(wg,p-pg));
    V f=mul(G,V{-tcM*N*tanh(v.x/5e-4),0,-N});F=F+f;T=T+cross(r,f);}}
  if(k>=0&&k%per==0){Rec q;q.t=t;q.gp=pg;q.gq=gq;q.op=po;q.oq=qo;q.f1=f1;q.t1=t1;q.f2=f2;q.t2=t2;q.pf=pf;q.pt=pt;out.push_back(q);}
  // grip that acts
  D tgt=0;if(t>0&&(drop!=0||d1!=0)){slipAcc+=slipv*dt;tgt=drop*(slipv/(slipv+knee))+d1*slipAcc;}
  if(gtau>0)lossF+=(tgt-lossF)*dt/gtau;else lossF=tgt;
  D Fact=(c.grip*gripF*dayGrip*(1-glF)-glO)*(1+gg1*pgo.x)*(1-lossF);
  D da=(Fact-jawN-jc*dv)/S.jawM;dv+=da*dt;d+=dv*dt;
  if(t<-.1){D q=1-300*dt;vo=vo*q;wo=wo*q;}
  vo=vo+F*(dt/m);po=po+vo*dt;
  V Tb=tmul(O,T),wb=tmul(O,wo);V Lw={Ix*wb.x,Iy*wb.y,Iy*wb.z};V gy=cross(wb,Lw);
  wb.x+=(Tb.x-gy.x)/Ix*dt;wb.y+=(Tb.y-gy.y)/Iy*dt;wb.z+=(Tb.z-gy.z)/Iy*dt;wo=mul(O,wb);
  Q dq={1,wb.x*dt/2,wb.y*dt/2,wb.z*dt/2};qo=qmul(qo,dq);qnorm(qo);
  if(!(po.x<10&&po.x>-10)){fprintf(stderr,"diverged trial %d t %g\n",idx,t);exit(3);}
 }
}
static V rot3(V v,D rx,D ry,D rz){return mul(qmat(qmul(qaa({0,0,1},rz),qmul(qaa({0,1,0},ry),qaa({1,0,0},rx)))),v);}
static void sense(V&f,V&t,const string&b,bool finger,const D*bias,D nf,D nt,D gain){
 V f0=f;auto k=[&](const char*a,const string&n){return e((string(a)+"."+b+n).c_str());};
 if(E.size()){ if(finger){f.x+=k("sensor_crosstalk","_to_x")*f0.y;f.z+=k("sensor_crosstalk","_to_z")*f0.y;t.x+=k("sensor_crosstalk","_to_tx_m")*f0.y;t.y+=k("sensor_crosstalk","_to_ty_m")*f0.y;t.z+=k("sensor_crosstalk","_to_tz_m")*f0.y;}
  else{f.y+=k("sensor_crosstalk","_to_y")*f0.x;f.z+=k("sensor_crosstalk","_to_z")*f0.x;t.x+=k("sensor_crosstalk","_to_tx_m")*f0.x;t.y+=k("sensor_crosstalk","_to_ty_m")*f0.x;t.z+=k("sensor_crosstalk","_to_tz_m")*f0.x;}
  D rx=k("sensor_misalignment","_x_rad"),ry=k("sensor_misalignment","_y_rad"),rz=k("sensor_misalignment","_z_rad");if(rx||ry||rz){f=rot3(f,rx,ry,rz);t=rot3(t,rx,ry,rz);}
  D g=1+e(("sensor_gain."+b).c_str());f=f*g;t=t*g;
  f=f+V{k("sensor_bias","_fx_n"),k("sensor_bias","_fy_n"),k("sensor_bias","_fz_n")};t=t+V{k("sensor_bias","_tx_nm"),k("sensor_bias","_ty_nm"),k("sensor_bias","_tz_nm")};}
 f=f+V{bias[0]+nf*R.n(),bias[1]+nf*R.n(),bias[2]+nf*R.n()};t=t+V{bias[3]+nt*R.n(),bias[4]+nt*R.n(),bias[5]+nt*R.n()};(void)gain;}
static D r3(D x){return x==0?0:strtod([&]{static char b[40];snprintf(b,40,"%.4g",x);return b;}(),0);}
static void drawEffect(const string&id){
 Eff x;x.id=id;P&p=x.p;
 if(id=="static_friction"){p["excess"]=R.U(.18,.4);p["stribeck_speed_m_s"]=R.L(.001,.005);p["elsewhere"]=0;}
 else if(id=="viscous_friction"){p["viscosity_s_m"]=R.U(3,8);p["elsewhere"]=0;}
 else if(id=="dwell_strengthening"){p["strengthening"]=R.U(.04,.09);p["cutoff_s"]=R.L(.03,.2);p["renewal_m"]=R.L(2e-5,1e-4);p["elsewhere"]=0;}
 else if(id=="load_dependent_friction"){p["exponent"]=R.U(.17,.35);p["elsewhere"]=0;}
 else if(id=="anisotropic_friction"){D r=R.U(1.35,1.7);p["ratio"]=R.u()<.5?r:1/r;}
 else if(id=="finger_friction_mismatch")p["mismatch"]=R.sg()*R.U(.14,.3);
 else if(id=="wear_drift")p["rate_per_trial"]=R.sg()*R.U(.004,.008);
 else if(id=="torsional_friction")p["radius_change_m"]=R.sg()*R.U(.0014,.002);
 else if(id=="pressure_offset"){p["offset_x_m"]=R.sg()*R.U(.0012,.0022);p["offset_z_m"]=R.sg()*R.U(.0005,.001);}
 else if(id=="face_tilt"){int k=R.I(0,2);if(k==0)p["slope_rad"]=R.sg()*R.U(.008,.016);else if(k==1)p["friction_gradient_1_m"]=R.sg()*R.U(10,20);else p["grip_gradient_1_m"]=R.sg()*R.U(10,20);}
 else if(id=="face_waviness"){p["amplitude"]=R.U(.1,.2);p["wavelength_m"]=R.L(.004,.009);p["phase_rad"]=R.U(-3,3);}
 else if(id=="plate_tilt"){p["pitch_rad"]=R.sg()*R.U(.008,.02);p["yaw_rad"]=R.sg()*R.U(.006,.014);}
 else if(id=="adhesion")p["pull_off_n"]=R.U(2.5,5);
 else if(id=="grip_force_loss"){if(R.u()<.5)p["fraction"]=R.U(.1,.2);else p["offset_n"]=R.U(1.5,3);}
 else if(id=="grip_force_lag"){p["drop"]=R.U(.12,.22);p["time_s"]=R.L(.05,.25);p["knee_m_s"]=R.L(.001,.003);p["sharpness"]=1;}
 else if(id=="mass_error"){p["fraction"]=R.U(.15,.3);p["com_x_m"]=R.sg()*R.U(.004,.008);}
 else if(id=="external_force"){p["x_n"]=R.sg()*R.U(.3,.8);p["y_n"]=R.sg()*R.U(.2,.6);p["z_n"]=R.sg()*R.U(.3,.8);}
 else if(id=="gravity_tilt"){p["about_x_rad"]=R.sg()*R.U(.06,.12);p["about_y_rad"]=R.sg()*R.U(.06,.12);}
 else if(id=="sensor_bias"){p["finger1_fx_n"]=R.sg()*R.U(.2,.4);p["finger2_fz_n"]=R.sg()*R.U(.2,.4);p["pusher_fx_n"]=R.sg()*R.U(.25,.5);}
 else if(id=="sensor_gain"){const char*w[3]={"finger1","finger2","pusher"};p[w[R.I(0,2)]]=R.sg()*R.U(.06,.13);}
 else if(id=="sensor_misalignment"){p[string("finger")+(R.u()<.5?"1":"2")+(R.u()<.5?"_x_rad":"_z_rad")]=R.sg()*R.U(.03,.07);}
 else if(id=="sensor_crosstalk"){string f=R.u()<.5?"finger1":"finger2";p[f+"_to_x"]=R.sg()*R.U(.02,.04);p[f+"_to_z"]=R.sg()*R.U(.015,.03);}
 else if(id=="mocap_latency")p["latency_s"]=R.U(.02,.05);
 else if(id=="unlisted:magnetic_plate"){p["force_n"]=R.U(2,4);p["range_m"]=R.U(.002,.006);}
 else if(id=="unlisted:loose_pusher"){p["play_m"]=R.U(.0004,.001);p["spring_n_m"]=R.U(200,800);}
 else if(id=="unlisted:third_contact"){p["force_n"]=R.U(1,2.5);p["from_m"]=R.U(.002,.004);p["to_m"]=R.U(.006,.009);p["friction"]=R.U(.3,.6);}
 else if(id=="unlisted:thermal_grip"){p["amplitude"]=R.sg()*R.U(.06,.12);p["trials_per_day"]=R.U(20,50);p["phase_rad"]=R.U(-3,3);}
 else{fprintf(stderr,"unknown effect %s\n",id.c_str());exit(2);}
 for(auto&q:p){q.second=r3(q.second);E[id+"."+q.first]=q.second;}
 effs.push_back(x);
}
int main(int ac,char**av){
 if(ac<6){fprintf(stderr,"sim11 NUMBER SEED EFFECTS FOLDER KEY.json [dt_div [only]]\n");return 1;}
 uint64_t seed=strtoull(av[2],0,10);R.g.seed(seed*2654435761ULL+11);for(int i=0;i<9;i++)R.g();
 string ef=av[3];int dtdiv=ac>6?atoi(av[6]):1;int only=ac>7?atoi(av[7]):-1;
 // nuisances
 S.hx=R.U(.04,.06);S.side=r3(R.U(.0245,.030));S.hx=r3(2*S.hx)/2;S.dia=r3(R.U(.015,.020));
 S.mu_f=R.U(.25,.9);S.mu_p=R.U(.12,.7);S.Kt=R.L(8e3,2.5e6);S.Kn=S.Kt*R.U(1,3);S.Kp=R.L(3e5,8e6);S.Kpt=S.Kp/R.U(1.1,2.5);
 cN=R.I(0,2);cS=R.I(0,2);if(cN==0)cS=0;cP=R.I(0,1);S.gamma=R.U(-.1,.3);S.kmr=R.U(.03,.35);S.tau=R.L(.005,.3);S.kmrp=R.U(.02,.15);S.taup=R.L(.005,.1);
 S.zeta=R.U(.06,.25);S.nbw=R.I(1,4);S.nbwp=R.I(2,4);S.jawM=R.U(.15,.4);S.jawZ=R.U(.4,1);
 S.yaw=R.U(-1e-3,1e-3);S.pitch=R.U(-1e-3,1e-3);
 S.sF=R.L(.005,.05);S.sT=R.L(.0002,.0015);S.sPf=min(.05,S.sF*R.U(1,2));S.sPt=min(.003,S.sT*R.U(1,4));S.sPos=R.L(5e-6,4e-5);S.sRot=S.sPos*R.U(6,12);
 S.rep=R.L(.005,.04);
 for(int f=0;f<2;f++)for(int i=0;i<6;i++)S.bF[f][i]=i<3?R.U(-.6,.6)*S.sF:R.U(-.6,.6)*S.sT;
 for(int i=0;i<6;i++)S.bP[i]=i<3?R.U(-.6,.6)*S.sPf:R.U(-.6,.6)*S.sPt;
 int nob=R.u()<.4?2:1;S.mass.push_back(r3(R.L(.06,.3)));if(nob==2)S.mass.push_back(r3(min(.4,S.mass[0]*R.U(1.4,2.2))));
 D mmax=*max_element(S.mass.begin(),S.mass.end());
 D gmin=max(R.U(8,20),3.0*mmax*9.81/(2*S.mu_f)),gmax=gmin*R.U(1.7,2.2);gmin=round(gmin);gmax=round(gmax);D gmid=round(sqrt(gmin*gmax));vector<D> grips={gmin,gmid,gmax};
 S.Nref=gmid;
 D belF=S.mu_f*(1+R.U(-.3,.3)),belP=S.mu_p*(1+R.U(-.3,.3));
 // effects
 if(ef!="none"){string t;for(char ch:ef+"+"){if(ch=='+'){drawEffect(t);t.clear();}else t+=ch;}}
 if(getenv("SIM11_NOEFF"))E.clear();
 auto fill=[&](FricP&f,bool els){D s=els?1:0;auto k=[&](const char*n){return els?e((string(n)+".elsewhere").c_str()):1.0;};(void)s;
  f.ex=e("static_friction.excess")*k("static_friction");if(E.count("static_friction.stribeck_speed_m_s"))f.vst=e("static_friction.stribeck_speed_m_s");
  f.vis=e("viscous_friction.viscosity_s_m")*k("viscous_friction");f.str=e("dwell_strengthening.strengthening")*k("dwell_strengthening");
  if(E.count("dwell_strengthening.cutoff_s")){f.cut=e("dwell_strengthening.cutoff_s");f.L=e("dwell_strengthening.renewal_m");}
  f.any=f.ex!=0||f.vis!=0||f.str!=0;};
 fill(fF,false);fill(fP,true);
 // pads
 D a=S.dia/2+1.5*e("torsional_friction.radius_change_m");D wsum=0,rsum=0;
 for(int r=0;r<3;r++){D rr=sqrt((r+.5)/3);D w=pow(1-rr*rr,S.gamma)/6;for(int i=0;i<6;i++){D th=(i+.5*(r%2)+.13)*M_PI/3;padEl.push_back(array<D,3>{a*rr*cos(th)+e("pressure_offset.offset_x_m"),a*rr*sin(th)+e("pressure_offset.offset_z_m"),w});wsum+=w;rsum+=w*rr*a;}}
 for(auto&x:padEl)x[2]/=wsum;
 D reff=rsum/wsum-S.dia/3;
 // conditions
 vector<D> sp={r3(R.U(.006,.010)),r3(R.U(.014,.02)),r3(R.U(.026,.04))};D sl=r3(R.U(.15,.35));vector<D> slo={0,-sl,sl};
 vector<D> om={.0872665,.174533,.349066};vector<D> po={0,r3(R.U(.008,.014)),r3(R.U(.016,.022))};
 int nl=R.I(5,11),np=R.I(3,6),nc=R.u()<.5?R.I(1,3):0;int reps=(nl+np+nc)<=12&&R.u()<.5?3:2;while((nl+np+nc)*reps<24)nl++;
 bool pauses=R.u()<.5||ef.find("dwell")!=string::npos;
 vector<Cond> cs;set<tuple<string,int,D,D,D,D>> seen;
 auto add=[&](const string&pr,int n){int made=0,i=R.I(0,2),tries=0;while(made<n&&tries++<500){Cond c;c.prim=pr;c.obj=R.I(0,nob-1);c.grip=grips[(made+i)%3];c.v=c.w=c.slope=c.poff=c.x0=c.pause=0;c.run=0;
   c.rest=R.u()<.5?.35:R.U(.25,1.1);c.acc=R.U(.03,.09);c.gap=r3(R.U(.00015,.0005));
   if(pr=="linear_push"){c.v=sp[R.I(0,2)];c.slope=slo[made<2?0:R.I(0,2)];c.poff=0;c.x0=r3(R.u()<.4?0:R.U(-.012,.012));c.travel=min(.014,max(.0085,c.v*.7));if(pauses&&R.u()<.4)c.pause=R.U(.25,.9);}
   else if(pr=="pivot"){c.w=om[R.I(0,2)];c.poff=po[R.I(0,2)];c.travel=min(.22,max(.1,c.w*.7));c.x0=r3(R.u()<.6?0:R.U(-.006,.006));}
   else {c.v=r3(R.U(.02,.06));D lim=.35*2*.6*S.mu_f*c.grip*S.dia/2/(S.mass[c.obj]*9.81);c.x0=r3(R.sg()*min(.02,lim));c.travel=.03;}
   auto key=make_tuple(pr,c.obj,c.grip,pr=="pivot"?c.w:c.v,c.slope,c.poff);if(seen.count(key))continue;seen.insert(key);cs.push_back(c);made++;}};
 add("linear_push",nl);add("pivot",np);if(nc)add("carry",nc);
 vector<Cond> tr;for(auto&c:cs)for(int r=0;r<reps;r++){Cond q=c;q.run=r;tr.push_back(q);}
 for(size_t i=tr.size();i>1;i--)swap(tr[i-1],tr[R.g()%i]);
 {map<tuple<string,int,D,D,D,D>,int> cnt;for(auto&c:tr)c.run=cnt[make_tuple(c.prim,c.obj,c.grip,c.prim=="pivot"?c.w:c.v,c.slope,c.poff)]++;}
 // time step
 D mmin=*min_element(S.mass.begin(),S.mass.end());D om0=sqrt((2*max(S.Kn,S.Kt)*(1+S.kmr)*2+S.Kp*1.2*2)/mmin);D dt=.12/om0;dt=dt<2e-5?1e-5:2e-5;dt/=dtdiv;
 string fold=av[4];filesystem::create_directories(fold+"/trials");
 FILE*f=fopen((fold+"/dataset.toml").c_str(),"w");
 fprintf(f,"format = \"stickslip-dataset/1\"\nname = \"bench %s\"\nsample_rate_hz = 250.0\ngravity_m_s2 = [0.0, 0.0, -9.81]\n",av[1]);
 for(int i=0;i<nob;i++)fprintf(f,"\n[[objects]]\nid = \"obj%d\"\nshape = \"prism\"\nlength_m = %.6g\nside_m = %.6g\nmass_kg = %.6g\n",i+1,2*S.hx,S.side,S.mass[i]);
 fprintf(f,"\n[fingers]\ncontact = \"disc\"\ndiameter_m = %.6g\nbelieved_friction = %.3g\n\n[pushers.linear_push]\ncontact = \"plane\"\nbelieved_friction = %.3g\n\n[pushers.pivot]\ncontact = \"line\"\nlength_m = 0.028\nbelieved_friction = %.3g\n",S.dia,belF,belP,belP);
 fprintf(f,"\n[sensors.finger]\nforce_noise_n = %.3g\nforce_uncertainty_n = %.3g\ntorque_noise_nm = %.3g\ntorque_uncertainty_nm = %.3g\n",S.sF,.25,S.sT,.003);
 fprintf(f,"\n[sensors.pusher]\nforce_noise_n = %.3g\nforce_uncertainty_n = %.3g\ntorque_noise_nm = %.3g\ntorque_uncertainty_nm = %.3g\n",S.sPf,.75,S.sPt,.037);
 fprintf(f,"\n[sensors.pose]\nposition_noise_m = %.3g\nrotation_noise_rad = %.3g\n",S.sPos,S.sRot);fclose(f);
 f=fopen((fold+"/trials.csv").c_str(),"w");
 fprintf(f,"trial,file,object,primitive,grip_n,speed_m_s,speed_rad_s,slope_rad,pusher_offset_m,run,pusher_x_m,pusher_y_m,pusher_z_m,pusher_qw,pusher_qx,pusher_qy,pusher_qz\n");
 D lat=e("mocap_latency.latency_s");
 for(size_t i=0;i<tr.size();i++){
  Cond&c=tr[i];char id[16];snprintf(id,16,"t%04zu",i);
  fprintf(f,"%s,trials/%s.csv,obj%d,%s,%g,",id,id,c.obj+1,c.prim.c_str(),c.grip);
  bool lin=c.prim=="linear_push",piv=c.prim=="pivot";
  if(lin)fprintf(f,"%g,,%g,,%d,%.7g,%.7g,0,1,0,0,0\n",c.v,c.slope,c.run,c.x0-S.hx-c.gap,c.poff);
  else if(piv)fprintf(f,",%g,,%g,%d,%.7g,0,%.7g,0.707106781,0,-0.707106781,0\n",c.w,c.poff,c.run,c.x0-S.hx+.005+c.poff,-S.side/2-c.gap);
  else fprintf(f,"%g,,,,%d,,,,,,,\n",c.v,c.run);
  D mff=exp(S.rep*R.n()),mfp=exp(S.rep*R.n()),m12[2]={exp(.3*S.rep*R.n()),exp(.3*S.rep*R.n())},gf=1+.002*R.n(),ge=3e-5*R.n();if(c.gap+ge<5e-5)ge=0;
  D day=1;if(E.count("unlisted:thermal_grip.amplitude"))day=1-e("unlisted:thermal_grip.amplitude")*sin(2*M_PI*i/e("unlisted:thermal_grip.trials_per_day")+e("unlisted:thermal_grip.phase_rad"));
  mt19937_64 keep=R.g;R.g.seed(seed*1000003ULL+i*7919+5);
  vector<Rec> o;if(only<0||only==(int)i)simulate(c,i,dt,mff,mfp,m12,gf,ge,day,o);
  FILE*h=fopen((fold+"/trials/"+id+".csv").c_str(),"w");bool pu=lin||piv;
  fprintf(h,"t_s,grip_cmd_n,gripper_x_m,gripper_y_m,gripper_z_m,gripper_qw,gripper_qx,gripper_qy,gripper_qz,object_x_m,object_y_m,object_z_m,object_qw,object_qx,object_qy,object_qz");
  for(int k=1;k<=2;k++)fprintf(h,",finger%d_fx_n,finger%d_fy_n,finger%d_fz_n,finger%d_tx_nm,finger%d_ty_nm,finger%d_tz_nm",k,k,k,k,k,k);
  if(pu)fprintf(h,",pusher_fx_n,pusher_fy_n,pusher_fz_n,pusher_tx_nm,pusher_ty_nm,pusher_tz_nm");fprintf(h,"\n");
  bool nonoise=getenv("SIM11_CLEAN")!=nullptr;
  for(size_t k=0;k<o.size();k++){
   Rec q=o[k];V op=q.op;Q oq=q.oq;
   if(lat!=0){D x=max(0.,k-lat*250);size_t k0=(size_t)x;size_t k1=min(o.size()-1,k0+1);D w=x-k0;op=o[k0].op*(1-w)+o[k1].op*w;Q A=o[k0].oq,B=o[k1].oq;oq={A.w*(1-w)+B.w*w,A.x*(1-w)+B.x*w,A.y*(1-w)+B.y*w,A.z*(1-w)+B.z*w};qnorm(oq);}
   if(!nonoise){sense(q.f1,q.t1,"finger1",true,S.bF[0],S.sF,S.sT,1);sense(q.f2,q.t2,"finger2",true,S.bF[1],S.sF,S.sT,1);sense(q.pf,q.pt,"pusher",false,S.bP,S.sPf,S.sPt,1);
    op=op+V{S.sPos*R.n(),S.sPos*R.n(),S.sPos*R.n()};oq=qmul(oq,Q{1,S.sRot*R.n()/2,S.sRot*R.n()/2,S.sRot*R.n()/2});qnorm(oq);}
   fprintf(h,"%.7g,%g,%.8g,%.8g,%.8g,%.9g,%.9g,%.9g,%.9g,%.8g,%.8g,%.8g,%.9g,%.9g,%.9g,%.9g",q.t,c.grip,q.gp.x,q.gp.y,q.gp.z,q.gq.w,q.gq.x,q.gq.y,q.gq.z,op.x,op.y,op.z,oq.w,oq.x,oq.y,oq.z);
   for(V*v:{&q.f1,&q.t1,&q.f2,&q.t2})fprintf(h,",%.7g,%.7g,%.7g",v->x,v->y,v->z);
   if(pu)for(V*v:{&q.pf,&q.pt})fprintf(h,",%.7g,%.7g,%.7g",v->x,v->y,v->z);
   fprintf(h,"\n");}
  fclose(h);R.g=keep;
 }
 fclose(f);
 FILE*k=fopen(av[5],"w");
 fprintf(k,"{\n \"number\": %s,\n \"seed\": %s,\n \"effects\": [",av[1],av[2]);
 for(size_t i=0;i<effs.size();i++){fprintf(k,"%s\n  {\"id\": \"%s\", \"params\": {",i?",":"",effs[i].id.c_str());bool fst=true;for(auto&q:effs[i].p){fprintf(k,"%s\"%s\": %.6g",fst?"":", ",q.first.c_str(),q.second);fst=false;}fprintf(k,"}}");}
 fprintf(k,"],\n \"mu_finger\": %.5g,\n \"mu_pusher\": %.5g,\n \"pad_tangential_n_m\": %.5g,\n \"pad_normal_n_m\": %.5g,\n \"pusher_n_m\": %.5g,\n \"pusher_tangential_n_m\": %.5g,\n \"plate_yaw_rad\": %.5g,\n \"plate_pitch_rad\": %.5g,\n \"trials\": %zu,\n",
  S.mu_f,S.mu_p,S.Kt,S.Kn,S.Kp,S.Kpt,S.yaw,S.pitch,tr.size());
 fprintf(k," \"believed_mu_finger\": %.5g,\n \"believed_mu_pusher\": %.5g,\n \"conditions\": %zu,\n \"repetitions\": %d,\n \"repetition_friction_sd\": %.4g,\n \"reference_grip_n\": %g,\n \"pad_normal_exponent\": %g,\n \"pad_stiffening_exponent\": %g,\n \"pad_pressure_exponent\": %.4g,\n \"pad_effective_radius_change_m\": %.5g,\n \"pad_maxwell_share\": %.4g,\n \"pad_maxwell_s\": %.4g,\n \"pad_boucwen_n\": %d,\n \"plate_normal_exponent\": %g,\n \"damping_ratio\": %.4g,\n \"time_step_s\": %g\n}\n",
  belF,belP,cs.size(),reps,S.rep,S.Nref,pexp(cN),cS*.25,S.gamma,reff,S.kmr,S.tau,S.nbw,pexp(cP),S.zeta,dt);
 fclose(k);return 0;}
