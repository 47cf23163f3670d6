// sim9: compliant (elasto-plastic brush) simulator of a gripper that pushes a grasped prism.
// usage: ./sim9 NUMBER SEED EFFECTS SET_FOLDER KEY.json [dt_us] [clean]
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>
#include <map>
#include <set>
#include <algorithm>
#include <sys/stat.h>
using namespace std;
typedef double D;
struct Rng{ uint64_t s; Rng(uint64_t a=1,uint64_t b=0){s=a*0x9E3779B97F4A7C15ULL^(b*0xD1B54A32D192ED03ULL+0x1234567);for(int i=0;i<4;i++)nx();}
 uint64_t nx(){uint64_t z=(s+=0x9E3779B97F4A7C15ULL);z=(z^(z>>30))*0xBF58476D1CE4E5B9ULL;z=(z^(z>>27))*0x94D049BB133111EBULL;return z^(z>>31);}
 D u(){return (nx()>>11)*(1.0/9007199254740992.0);} D u(D a,D b){return a+(b-a)*u();} D lu(D a,D b){return a*pow(b/a,u());}
 D n(){D a=u()+1e-18,b=u();return sqrt(-2*log(a))*cos(2*M_PI*b);} int k(int n){return int(nx()%n);} D sg(){return nx()>>63?1.:-1.;} };
static uint64_t hashs(const string&s){uint64_t h=1469598103934665603ULL;for(char c:s){h^=(unsigned char)c;h*=1099511628211ULL;}return h;}
struct V{D x=0,y=0,z=0;};
static inline V operator+(V a,V b){return{a.x+b.x,a.y+b.y,a.z+b.z};} static inline V operator-(V a,V b){return{a.x-b.x,a.y-b.y,a.z-b.z};}
static inline V operator*(D s,V a){return{s*a.x,s*a.y,s*a.z};} static inline D dot(V a,V b){return a.x*b.x+a.y*b.y+a.z*b.z;}
static inline V cr(V a,V b){return{a.y*b.z-a.z*b.y,a.z*b.x-a.x*b.z,a.x*b.y-a.y*b.x};} static inline V&operator+=(V&a,V b){a=a+b;return a;}
struct M{V a,b,c;}; // rows
static inline V mul(const M&m,V v){return{dot(m.a,v),dot(m.b,v),dot(m.c,v)};}
static inline V tmul(const M&m,V v){return v.x*m.a+(v.y*m.b+v.z*m.c);}
static inline M tr(const M&m){return{{m.a.x,m.b.x,m.c.x},{m.a.y,m.b.y,m.c.y},{m.a.z,m.b.z,m.c.z}};}
static inline M mm(const M&p,const M&q){M t=tr(q);return{{dot(p.a,t.a),dot(p.a,t.b),dot(p.a,t.c)},{dot(p.b,t.a),dot(p.b,t.b),dot(p.b,t.c)},{dot(p.c,t.a),dot(p.c,t.b),dot(p.c,t.c)}};}
struct Q{D w=1,x=0,y=0,z=0;};
static Q qm(Q a,Q b){return{a.w*b.w-a.x*b.x-a.y*b.y-a.z*b.z,a.w*b.x+a.x*b.w+a.y*b.z-a.z*b.y,a.w*b.y-a.x*b.z+a.y*b.w+a.z*b.x,a.w*b.z+a.x*b.y-a.y*b.x+a.z*b.w};}
static Q qn(Q q){D n=1/sqrt(q.w*q.w+q.x*q.x+q.y*q.y+q.z*q.z);return{q.w*n,q.x*n,q.y*n,q.z*n};}
static Q qv(V r){D t=sqrt(dot(r,r));D s=t<1e-9?0.5:sin(t/2)/t;return qn({cos(t/2),s*r.x,s*r.y,s*r.z});}
static M qmat(Q q){D w=q.w,x=q.x,y=q.y,z=q.z;return{{1-2*(y*y+z*z),2*(x*y-w*z),2*(x*z+w*y)},{2*(x*y+w*z),1-2*(x*x+z*z),2*(y*z-w*x)},{2*(x*z-w*y),2*(y*z+w*x),1-2*(x*x+y*y)}};}
static const D g0=9.81;
// ------------------------------------------------------------------ set
typedef map<string,D> P;
map<string,P> eff; set<string> has_; static bool has(const char*s){return has_.count(s);} static D par(const char*e,const char*p){auto i=eff.find(e);if(i==eff.end())return 0;auto j=i->second.find(p);return j==i->second.end()?0:j->second;}
struct Cond{bool pivot;D grip,speed,slope,off;}; struct Tr{int cond,run;};
struct Set{ D muf,mup,K,Kn,Dp,side,L,mass,path,ramp,rest,endrest,gap,pause,sr,zeta,creep,stiffExp,pexp,jawk,jawtau,Kp,graspx,pivang,linelen,scatter; int nel,dahl; bool hasPivot;
 vector<D> grips; vector<Cond> conds; vector<Tr> order; V W0; D Nref; bool pausing;
 D fnoise,func,tnoise,tunc,pfn,pfu,ptn,ptu,posn,rotn,clock; D bias[18]; V turn[3]; D xt[3][36]; V psq; D lineSq; D torArm; } S;
struct Pad{vector<D> x,z,sh,kt,kn;} pad[2];
static void tiltTo(Pad&p,D ox,D oz){ int n=p.x.size(); vector<D> w0=p.sh; D gx=0,gz=0; for(int it=0;it<60;it++){D s=0,mx=0,mz=0,xx=0,xz=0,zz=0; for(int i=0;i<n;i++){D w=w0[i]*exp(gx*p.x[i]+gz*p.z[i]);p.sh[i]=w;s+=w;mx+=w*p.x[i];mz+=w*p.z[i];xx+=w*p.x[i]*p.x[i];xz+=w*p.x[i]*p.z[i];zz+=w*p.z[i]*p.z[i];}
  for(D&w:p.sh)w/=s; mx/=s;mz/=s;xx=xx/s-mx*mx;xz=xz/s-mx*mz;zz=zz/s-mz*mz; D ex=ox-mx,ez=oz-mz,dt=xx*zz-xz*xz; D dx=(ex*zz-ez*xz)/dt,dz=(ez*xx-ex*xz)/dt; D l=hypot(dx,dz)*S.Dp/2; D f=l>0.7?0.7/l:1; gx+=f*dx;gz+=f*dz; } }
static void plan(uint64_t seed){ Rng r(seed,1); auto&s=S;
 s.muf=r.u(.25,1);s.mup=r.u(.15,.6);s.K=r.lu(15e3,3e6);s.Kn=min(4e6,max(2e5,s.K*r.u(1,4)));s.Dp=round(r.u(10,24)*2)/2*1e-3;s.side=round(max(s.Dp*1e3+3,r.u(20,40))*2)/2*1e-3;s.L=round(r.u(80,140))*1e-3;
 int ng=3+r.k(2);D g1=r.u(8,18),g2=r.u(max(g1*1.6,22.),40);for(int i=0;i<ng;i++)s.grips.push_back(round(g1+(g2-g1)*i/(ng-1)));
 s.graspx=r.u()<.5?0:round(r.u(-6,6)*2)/2*1e-3;
 D mmax=.35*2*s.muf*s.grips[0]/g0; D cap=2*.62*s.muf*s.grips[0]*s.Dp/2; mmax=min(mmax,.45*cap/(g0*(fabs(s.graspx)+.006))); mmax=min(.5,max(.085,mmax)); s.mass=round(r.lu(.08,mmax)*1e4)/1e4;
 s.path=r.u(5,15)*1e-3;s.ramp=r.u(.02,.09);s.rest=r.u(.3,.8);s.endrest=r.u(.15,.4);s.gap=r.u(.2,.7)*1e-3;s.pausing=r.u()<.35;s.pause=s.pausing?r.u(.2,.8):0;s.sr=r.u()<.6?250:500;
 s.zeta=r.u(.1,.3);s.creep=r.u()<.4?1/r.lu(20,100):0;s.stiffExp=vector<D>{0,.15,.33}[r.k(3)];s.pexp=r.u(0,.5);s.jawk=r.lu(2e4,3e5);s.jawtau=r.u(.008,.04);s.Kp=r.lu(3e5,5e6);
 s.nel=20+r.k(17);s.dahl=vector<int>{0,2,4,8}[r.k(4)];s.hasPivot=r.u()<.7;s.pivang=r.u(.15,.5);s.linelen=round(r.u(.7,1.1)*s.side*1e3)*1e-3;s.scatter=r.u(.01,.04);
 s.W0={round(r.u(-.2,.4)*1e3)*1e-3,round(r.u(-.2,.2)*1e3)*1e-3,round(r.u(0,.4)*1e3)*1e-3};
 D nr=0;for(D g:s.grips)nr+=g;s.Nref=nr/ng;
 // conditions
 int ns=2+r.k(2);D v1=r.lu(3,10),v2=r.lu(max(12.,v1*2),40);vector<D> sp;for(int i=0;i<ns;i++)sp.push_back(round(v1*pow(v2/v1,D(i)/(ns-1))*2)/2*1e-3);
 int nl=2+r.k(2);D sl=r.u(8,28)*M_PI/180;vector<D> slp;if(nl==2)slp={-sl,sl};else slp={-sl,0,sl};
 vector<D> om;D o1=r.lu(.05,.15),o2=r.lu(.2,.5);om={round(o1*1e3)*1e-3,round(o2*1e3)*1e-3}; vector<D> offs={0,round(r.u(8,20))*1e-3};
 vector<Cond> A,B;for(D g:s.grips){for(D v:sp)for(D l:slp)A.push_back({false,g,v,round(l*1e6)*1e-6,0});for(D o:om)for(D f:offs)B.push_back({true,g,o,0,f});}
 auto shf=[&](auto&v){for(int i=(int)v.size()-1;i>0;i--)swap(v[i],v[r.k(i+1)]);}; shf(A);shf(B);
 int nc=10+r.k(11);int np=s.hasPivot?max(3,int(nc*r.u(.25,.55))):0;np=min(np,(int)B.size());int nq=min(nc-np,(int)A.size());
 for(int i=0;i<nq;i++)s.conds.push_back(A[i]);for(int i=0;i<np;i++)s.conds.push_back(B[i]);
 stable_sort(s.conds.begin(),s.conds.end(),[](const Cond&a,const Cond&b){return a.pivot<b.pivot;});
 int C=s.conds.size();int reps=C*3<=60&&r.u()<.5?3:2; if(C*reps<24)reps=3;
 bool full=r.u()<.5; vector<Tr> all; for(int k=0;k<reps;k++){vector<Tr> b;for(int c=0;c<C;c++)b.push_back({c,k});shf(b);all.insert(all.end(),b.begin(),b.end());} if(full)shf(all);
 // run numbers rise with order
 vector<int> cnt(C,0);for(Tr&t:all)t.run=cnt[t.cond]++; s.order=all;
 // sensors
 s.fnoise=r.lu(.01,.04);s.func=r.u(.05,.2);s.tnoise=r.lu(1.5e-4,6e-4);s.tunc=r.u(.001,.003);s.pfn=r.lu(.02,.06);s.pfu=r.u(.1,.4);s.ptn=r.lu(5e-4,2e-3);s.ptu=r.u(.003,.012);s.posn=r.lu(1.5e-5,4e-5);s.rotn=r.lu(1e-4,4e-4);s.clock=r.u(-.5,.5)/s.sr;
 auto rd=[&](D&x,D q){x=round(x/q)*q;}; rd(s.fnoise,.001);rd(s.func,.01);rd(s.tnoise,1e-5);rd(s.tunc,1e-4);rd(s.pfn,.001);rd(s.pfu,.01);rd(s.ptn,1e-5);rd(s.ptu,1e-4);rd(s.posn,1e-6);rd(s.rotn,1e-5);
 for(int k=0;k<3;k++){for(int i=0;i<6;i++)s.bias[k*6+i]=r.u(-.7,.7)*(k<2?(i<3?s.func:s.tunc):(i<3?s.pfu:s.ptu)); V t={r.n(),r.n(),r.n()};s.turn[k]=(r.u(.001,.003)/sqrt(dot(t,t)))*t; for(int i=0;i<6;i++)for(int j=0;j<6;j++){D c=r.u(.001,.003)*r.sg();s.xt[k][i*6+j]=i==j?0:(i<3&&j<3?c:(i>=3&&j<3?c*.01:(i>=3?c:0)));}}
 s.psq={0,1e-4*r.n(),1e-4*r.n()};s.lineSq=1e-4*r.n();
 // pads
 D a=r.u(-.15,.35); D ga=M_PI*(3-sqrt(5.)); D dR=par("torsional_friction","radius_change_m");
 for(int f=0;f<2;f++){Pad&p=pad[f];D ph=r.u(0,6.28);D sum=0;for(int i=0;i<s.nel;i++){D q=sqrt((i+.5)/s.nel);D rr=q*(s.Dp/2+dR);p.x.push_back(rr*cos(ph+ga*i));p.z.push_back(rr*sin(ph+ga*i));D w=(1+a*(1-2*q*q))*(1+.05*r.n());p.sh.push_back(w);sum+=w;}for(D&w:p.sh)w/=sum;
  D bx=.005*s.Dp*r.n()*.7,bz=.005*s.Dp*r.n()*.7; tiltTo(p,bx+par("pressure_offset","offset_x_m"),bz+par("pressure_offset","offset_z_m"));
  D st=0;for(D w:p.sh){D k=pow(w*s.nel,s.pexp);p.kt.push_back(k);st+=k;}for(D&k:p.kt)k/=st; }
 D arm=0;for(int f=0;f<2;f++)for(int i=0;i<s.nel;i++)arm+=.5*pad[f].sh[i]*hypot(pad[f].x[i],pad[f].z[i]);s.torArm=arm;
}
static void drawEffects(uint64_t seed){ // needs geometry of plan only where it limits: done after a first plan()
 for(const string&e:has_){ Rng r(seed*31+7,hashs(e)); D f=exp(r.u(0,log(4.))); P p; auto F=[&]{return exp(r.u(0,log(4.)));}; D R=S.Dp/2;
  if(e=="static_friction"){p["excess"]=.2*f;p["stribeck_speed_m_s"]=.002*r.lu(.5,2);}
  else if(e=="viscous_friction")p["viscosity_s_m"]=2*f;
  else if(e=="dwell_strengthening"){p["strengthening"]=.05*f;p["cutoff_s"]=.05*r.lu(.5,2);p["renewal_m"]=2e-5*r.lu(.5,2);}
  else if(e=="load_dependent_friction")p["exponent"]=min(.6,.15*f);
  else if(e=="anisotropic_friction")p["ratio"]=exp(log(1.4)*f*r.sg());
  else if(e=="finger_friction_mismatch")p["mismatch"]=min(.6,.15*f)*r.sg();
  else if(e=="wear_drift")p["rate_per_trial"]=-.0006*f;
  else if(e=="torsional_friction"){D d=.002*f*r.sg();if(d<-.5*R)d=-d; d=min(d,.6*R); p["radius_change_m"]=d;}
  else if(e=="pressure_offset"){D x=.002*f,z=.001*F();D l=hypot(x,z);if(l>.4*R){x*=.4*R/l;z*=.4*R/l;}p["offset_x_m"]=x*r.sg();p["offset_z_m"]=z*r.sg();}
  else if(e=="face_tilt"){int k=r.k(3);if(k==0)p["slope_rad"]=.01*f*r.sg();if(k==1)p["friction_gradient_1_m"]=6*f*r.sg();if(k==2)p["grip_gradient_1_m"]=4*f*r.sg();}
  else if(e=="face_waviness"){p["wavelength_m"]=r.lu(.004,.012);p["phase_rad"]=r.u(-3,3);if(r.u()<.6)p["amplitude"]=.1*f;else p["grip_n"]=.5*f;}
  else if(e=="plate_tilt"){int k=r.k(3);if(k!=1)p["pitch_rad"]=.01*f*r.sg();if(k!=0)p["yaw_rad"]=.01*(k==2?F():f)*r.sg();if(S.hasPivot&&r.u()<.4)p["line_rad"]=.01*F()*r.sg();}
  else if(e=="adhesion")p["pull_off_n"]=f;
  else if(e=="grip_force_loss"){if(r.u()<.5)p["fraction"]=.1*f;else p["offset_n"]=min(f,.4*S.grips[0]);}
  else if(e=="grip_force_lag"){p["time_s"]=.1*r.lu(.5,2);p["knee_m_s"]=.001*r.lu(.5,2);if(r.u()<.6)p["drop"]=.12*f;else p["drop_1_m"]=5*f;}
  else if(e=="mass_error"){int k=r.k(3);if(k!=1)p["fraction"]=.1*f*(r.u()<.3?-1:1);if(k!=0)p["com_x_m"]=.004*min(k==2?F():f,2.5)*r.sg();}
  else if(e=="external_force"){int k=1+r.k(7);const char*n[3]={"x_n","y_n","z_n"};for(int i=0;i<3;i++)if(k>>i&1)p[n[i]]=.5*F()*r.sg();if(r.u()<.5)p["stiffness_n_m"]=20*F();if(r.u()<.3)p["at_x_m"]=r.u(-.02,.02);}
  else if(e=="gravity_tilt"){int k=1+r.k(3);if(k&1)p["about_x_rad"]=.05*F()*r.sg();if(k&2)p["about_y_rad"]=.05*F()*r.sg();}
  else if(e=="sensor_bias"){const char*sn[3]={"finger1","finger2","pusher"};const char*ch[6]={"fx_n","fy_n","fz_n","tx_nm","ty_nm","tz_nm"};int n=1+r.k(3);while((int)p.size()<n){int k=r.k(3),c=r.k(6);p[string(sn[k])+"_"+ch[c]]=(c<3?max(.25,k==2?S.pfu:S.func):max(.003,k==2?S.ptu:S.tunc))*F()*r.sg();}}
  else if(e=="sensor_gain"){const char*sn[3]={"finger1","finger2","pusher"};int n=1+(r.u()<.35);while((int)p.size()<n)p[sn[r.k(3)]]=.05*F()*r.sg();}
  else if(e=="sensor_misalignment"){const char*sn[3]={"finger1","finger2","pusher"};const char*ax[3]={"_x_rad","_y_rad","_z_rad"};int n=1+r.k(2);while((int)p.size()<n){int k=r.k(3),a=r.k(3);if(k<2&&a==1)continue;if(k==2&&a==0)continue;p[string(sn[k])+ax[a]]=.03*F()*r.sg();}}
  else if(e=="sensor_crosstalk"){const char*nm[15]={"finger1_to_x","finger2_to_x","finger1_to_z","finger2_to_z","finger1_to_tx_m","finger2_to_tx_m","finger1_to_ty_m","finger2_to_ty_m","finger1_to_tz_m","finger2_to_tz_m","pusher_to_y","pusher_to_z","pusher_to_tx_m","pusher_to_ty_m","pusher_to_tz_m"};int n=1+r.k(3);while((int)p.size()<n){int k=r.k(15);bool t=strstr(nm[k],"_m");p[nm[k]]=(t?.0005:.02)*F()*r.sg();}}
  else if(e=="mocap_latency")p["latency_s"]=.02*f;
  else if(e=="x_finger_play"){p["gap_m"]=r.lu(5e-5,3e-4);p["inner_stiffness_n_m"]=r.lu(2e3,8e3);}
  else if(e=="x_humid_run"){p["sd"]=r.u(.06,.15);p["rho"]=.8;}
  else if(e=="x_pusher_bends")p["rad_per_nm"]=r.lu(.005,.03);
  else if(e=="x_loose_mount"){p["finger"]=1+r.k(2);p["play_rad"]=r.u(.02,.06)*r.sg();p["threshold_n"]=r.u(.5,1.5);}
  else if(e=="x_cable_clamp"){p["stiffness_n_m"]=r.lu(200,800);p["yield_n"]=r.u(1,3);}
  else if(e=="x_thermal_fade"){p["fade_per_j"]=r.u(1,3);p["cooling_s"]=r.u(.5,3);}
  else {fprintf(stderr,"unknown effect %s\n",e.c_str());exit(2);}
  eff[e]=p; } }
// ------------------------------------------------------------------ trial
struct El{D zx=0,zz=0,th=0,vs=0;};
static inline void ep(D&zx,D&zz,D vx,D vz,D zm,int n,D dt,D&dx,D&dz){ // elasto-plastic bristle; dx,dz: rate of deflection
 D m2=zx*zx+zz*zz,ox=zx,oz=zz; D rx=vx,rz=vz; if(n&&m2>0){D q=zx*vx+zz*vz; if(q>0){D a=m2/(zm*zm+1e-30);if(a>1)a=1;D al=a;if(n>=4)al*=a;if(n>=8)al*=al; D k=al*q/m2; rx-=k*zx;rz-=k*zz;}}
 zx+=dt*rx;zz+=dt*rz; m2=zx*zx+zz*zz; if(m2>zm*zm){D k=zm/sqrt(m2);zx*=k;zz*=k;} dx=(zx-ox)/dt;dz=(zz-oz)/dt; }
struct Log{V p,g;Q q;D th;}; struct W6{D w[18];};
D DT=25e-6; bool CLEAN=false; D maxBal=0,maxBalAll=0;
static void addW(D*w,V f,V t){w[0]+=f.x;w[1]+=f.y;w[2]+=f.z;w[3]+=t.x;w[4]+=t.y;w[5]+=t.z;}
static void trial(uint64_t seed,int idx,const Tr&T,D humid,const string&file,V&push0,Q&pushq){
 const Cond&c=S.conds[T.cond]; Rng r(seed*1000003+idx,99); D dt=DT; const bool piv=c.pivot;
 D h=S.side/2,L=S.L; V cm={par("mass_error","com_x_m"),0,0}; D m=S.mass*(1+par("mass_error","fraction"));
 D Ix=m*(2*S.side*S.side)/12,Iy=m*(L*L+S.side*S.side)/12,Iz=Iy;
 D sc=1+S.scatter*r.n(); D sf[2]={sc*(1+.3*S.scatter*r.n()),sc*(1+.3*S.scatter*r.n())}; D mupr=S.mup*(1+S.scatter*r.n());
 D wear=pow(1+par("wear_drift","rate_per_trial"),idx)*humid; D mis=par("finger_friction_mismatch","mismatch");
 D mub[2]={S.muf*sf[0]*wear*(1+mis),S.muf*sf[1]*wear*(1-mis)};
 bool eS=has("static_friction"),eV=has("viscous_friction"),eD=has("dwell_strengthening"),eL=has("load_dependent_friction"),eA=has("anisotropic_friction"),eTh=has("x_thermal_fade"),ePlay=has("x_finger_play"),eCab=has("x_cable_clamp"),eBend=has("x_pusher_bends");
 D ex=par("static_friction","excess"),vst=par("static_friction","stribeck_speed_m_s"),visc=par("viscous_friction","viscosity_s_m"),ds=par("dwell_strengthening","strengthening"),dc=par("dwell_strengthening","cutoff_s"),dr=par("dwell_strengthening","renewal_m"),le=par("load_dependent_friction","exponent"),ar=eA?sqrt(par("anisotropic_friction","ratio")):1;
 D slope=par("face_tilt","slope_rad"),fg=par("face_tilt","friction_gradient_1_m"),gg=par("face_tilt","grip_gradient_1_m"); D wA=par("face_waviness","amplitude"),wG=par("face_waviness","grip_n"),wk=has("face_waviness")?2*M_PI/par("face_waviness","wavelength_m"):0,wp=par("face_waviness","phase_rad");
 D adh=par("adhesion","pull_off_n"); D lf=par("grip_force_loss","fraction"),lo=par("grip_force_loss","offset_n"); D drop=par("grip_force_lag","drop"),drop1=par("grip_force_lag","drop_1_m"),dtm=has("grip_force_lag")?par("grip_force_lag","time_s"):1,knee=has("grip_force_lag")?par("grip_force_lag","knee_m_s"):1; D lagx=0,slipsum=0;
 V grav={0,0,-g0}; if(has("gravity_tilt")){grav=mul(qmat(qv({0,par("gravity_tilt","about_y_rad"),0})),mul(qmat(qv({par("gravity_tilt","about_x_rad"),0,0})),grav));}
 V ef0={par("external_force","x_n"),par("external_force","y_n"),par("external_force","z_n")};D efm=sqrt(dot(ef0,ef0));V efu=efm>0?(1/efm)*ef0:V{};D efk=par("external_force","stiffness_n_m"),efat=par("external_force","at_x_m"); V efref;
 // geometry
 V pg=S.W0,vg; D th=0,om=0; V place={.1e-3*r.n(),0,.1e-3*r.n()};D pitch0=1e-3*r.n(),yaw0=1e-4*r.n(),roll0=1e-4*r.n();
 V go=pg+V{-S.graspx,0,0}+place; // geometry origin of the object
 Q q=qv({roll0,pitch0,yaw0}); M R=qmat(q); V x=go+mul(R,cm),v,w;
 V po; Q pq; if(!piv){po=pg+V{-S.graspx-L/2-S.gap,0,0};pq=Q{};}else{po=pg+V{-S.graspx-(L/2-.005)+c.off,0,-h-S.gap*.6};pq=Q{sqrt(.5),0,-sqrt(.5),0};}
 push0=po;pushq=pq;
 V ptilt={0,par("plate_tilt","pitch_rad")+S.psq.y,par("plate_tilt","yaw_rad")+S.psq.z}; if(piv)ptilt={0,0,par("plate_tilt","line_rad")+S.lineSq};
 M Rp=qmat(qm(pq,qv(ptilt)));
 // elements
 int n=S.nel; vector<El> E[2];E[0].resize(n);E[1].resize(n); D Ks=S.K*pow(c.grip/S.Nref,S.stiffExp); D ct=2*S.zeta*sqrt(Ks*m*.5)/Ks, cn=2*S.zeta*sqrt(S.Kn*m*.5)/S.Kn; ct=min(ct,4e-3);cn=min(cn,2e-3); ct=min(ct,.25*m/(2*Ks*dt));
 // rotational limits of explicit damping: about x with arm h
 ct=min(ct,.25*Ix/(2*Ks*h*h*dt)); cn=min(cn,.25*m/(2*S.Kn*dt));
 int npx=piv?7:16; vector<V> pp(npx);vector<El> PE(npx); if(!piv){int k=0;for(int i=0;i<4;i++)for(int j=0;j<4;j++)pp[k++]={-L/2,h*(-1+2*i/3.),h*(-1+2*j/3.)};}else{D l=min(S.linelen,S.side*.98)/2;for(int i=0;i<7;i++)pp[i]={0,l*(-1+i/3.),0};}
 D kp=S.Kp/npx,kpt=.7*kp,cp=min(2*.3*sqrt(S.Kp*m)/S.Kp,.25*m/(S.Kp*dt)); cp=min(cp,.25*Ix/(S.Kp*h*h*dt)); if(piv)cp=min(cp,.25*Iy/(S.Kp*L*L*.25*dt));
 // jaw
 D mj=.2,jw,jv=0,jc; D Fc=c.grip; { D k=S.Kn; jw=h-(S.graspx?0:0)+slope*(S.graspx)-c.grip/k; jc=jw-c.grip/S.jawk; } D cj=2*.5*sqrt(S.Kn*mj);
 D sa[2],sb[2]; {M Rr=R;for(int f=0;f<2;f++){D s=f?-1:1;V ng=mul(Rr,V{-slope,s,0});sa[f]=s*(-ng.x/ng.y);sb[f]=s*(-ng.z/ng.y);}}
 V u2,u2v; D cabz=0,cabx0=0; D heat[2]={0,0}; D pbend=0;
 // timeline (starts after settling)
 D tset=.25; D slopeA=c.slope; V dir={-cos(slopeA),0,sin(slopeA)}; D sp=c.speed,tot=piv?S.pivang:S.path; D Tm=tot/sp; D rp=min(S.ramp,.45*Tm*2); D t1=S.rest; D half=Tm/2+rp/2;
 auto prof=[&](D t,D len)->D{ // speed factor of one move of duration len+rp
   if(t<=0||t>=len+rp)return 0; if(t<rp)return .5-.5*cos(M_PI*t/rp); if(t>len)return .5-.5*cos(M_PI*(len+rp-t)/rp); return 1;};
 auto spd=[&](D t)->D{ t-=t1; if(!S.pausing)return sp*prof(t,Tm); D l2=Tm/2; if(rp>l2)return sp*prof(t,Tm); D a=prof(t,l2); if(a>0)return sp*a; return sp*prof(t-(l2+rp+S.pause),l2);};
 D tend=t1+Tm+rp+(S.pausing?S.pause+rp:0)+S.endrest; (void)half;
 D Ts=1/S.sr; long nst=long((tend+tset+.05)/dt); int per=int(round(Ts/dt)); long n0=long(round(tset/dt)); int ns=int(tend/Ts);
 vector<W6> acc(ns+1);memset(acc.data(),0,sizeof(W6)*acc.size());vector<int> cntv(ns+1,0); const int LG=max(1,int(round(5e-4/dt)));vector<Log> lg; long lg0=-1;
 V poNow=po; M RpN=Rp;
 for(long st=0;st<nst;st++){ D t=(st-n0)*dt; 
  if(st==n0){efref=x;slipsum=0;}
  D sv=t>0?spd(t):0; if(!piv)vg=sv*dir;else om=-sv;
  D cth=cos(th),sth=sin(th); M Rg={{cth,0,sth},{0,1,0},{-sth,0,cth}};
  M Rr={{cth*R.a.x-sth*R.c.x,cth*R.a.y-sth*R.c.y,cth*R.a.z-sth*R.c.z},R.b,{sth*R.a.x+cth*R.c.x,sth*R.a.y+cth*R.c.y,sth*R.a.z+cth*R.c.z}};
  V xr=x-pg; V d=tmul(Rg,xr); V wg={0,om,0}; V vr=tmul(Rg,v-vg-cr(wg,xr)),wr=tmul(Rg,w-wg);
  V Ft,Mt; D FN[2]; V WF[2],WT[2]; D slipm=0; 
  V org=d-mul(Rr,cm); V oc=tmul(Rr,V{}-org); D Xc=oc.x; // gripper middle in object axes
  D cw=wA!=0?1+wA*cos(wk*Xc+wp):1;
  for(int f=0;f<2;f++){ D s=f?-1:1; V qq=d+mul(Rr,V{0,s*h,0}-cm),ng=mul(Rr,V{-slope,s,0}); D iy=1/ng.y; D nn=1/sqrt(dot(ng,ng)); V nu=nn*ng; D y0=qq.y+(ng.x*qq.x+ng.z*qq.z)*iy,yx=-ng.x*iy,yz=-ng.z*iy; D sn=0; V F,T; D heatp=0,slp=0; D pvx=0,pvz=0; if(ePlay&&f==1){pvx=u2v.x;pvz=u2v.z;}
   Pad&p=pad[f]; D mu0=mub[f]*cw; if(eTh)mu0*=max(.3,1-par("x_thermal_fade","fade_per_j")*heat[f]); El*e=E[f].data(); D tfx=0,tfz=0;
   D dX=Rr.a.x,dZ=Rr.c.x; // object X in gripper axes x,z
   for(int i=0;i<n;i++){ D px=p.x[i],pz=p.z[i]; D yf=y0+yx*px+yz*pz; D pen=s*yf-jw-sa[f]*px-sb[f]*pz; V a={px-d.x,yf-d.y,pz-d.z}; D vx=vr.x+wr.y*a.z-wr.z*a.y,vy=vr.y+wr.z*a.x-wr.x*a.z,vz=vr.z+wr.x*a.y-wr.y*a.x;
    D pr=s*(ng.x*vx+ng.y*vy+ng.z*vz)*iy-jv; D k=S.Kn*p.sh[i]; D fn=k*(pen+cn*pr); if(pen<=0||fn<0){fn=0;}
    vx-=pvx;vz-=pvz; D mu=mu0; if(fg!=0)mu*=1+fg*(Xc+px*dX+pz*dZ);
    if(eS)mu*=1+ex/(1+1.71828*(e[i].vs/vst)*(e[i].vs/vst));
    if(eV)mu+=visc*e[i].vs;
    if(eD)mu*=1+ds*log1p(e[i].th/dc);
    if(eL){D pr0=fn/(S.Nref*p.sh[i])+.02;mu*=pow(pr0,-le);}
    D lim=mu*(fn+adh*p.sh[i]); D kt=Ks*p.kt[i]; D zm=lim/kt; D dx,dz; El&q=e[i];
    if(!eA)ep(q.zx,q.zz,vx,vz,zm,S.dahl,dt,dx,dz);
    else { D zl=q.zx*dX+q.zz*dZ,zc=-q.zx*dZ+q.zz*dX,vl=vx*dX+vz*dZ,vc=-vx*dZ+vz*dX; zl/=ar;zc*=ar; D a1,a2; ep(zl,zc,vl/ar,vc*ar,zm,S.dahl,dt,a1,a2); zl*=ar;zc/=ar;a1*=ar;a2/=ar; q.zx=zl*dX-zc*dZ;q.zz=zl*dZ+zc*dX;dx=a1*dX-a2*dZ;dz=a1*dZ+a2*dX; }
    if(S.creep>0){q.zx-=dt*S.creep*q.zx;q.zz-=dt*S.creep*q.zz;}
    D sx=vx-dx,sz=vz-dz,sl=sqrt(sx*sx+sz*sz); q.vs+=dt/1e-3*(sl-q.vs)/(1+dt/1e-3); slp+=p.sh[i]*sl; if(eD){q.th=(q.th+dt)*(1-min(.9,sl*dt/dr));} heatp+=lim*sl;
    D fx=-kt*(q.zx+ct*dx),fz=-kt*(q.zz+ct*dz); V fe={fx-nu.x*fn,-nu.y*fn,fz-nu.z*fn}; F+=fe; V ra={px,yf-y0,pz}; T+=cr(ra,fe); sn+=fn; tfx+=fx;tfz+=fz; }
   if(eTh)heat[f]+=dt*(heatp-heat[f]/par("x_thermal_fade","cooling_s"));
   if(ePlay&&f==1){ // pad hangs in its play: overdamped; pad gets -friction
     D kw=par("x_finger_play","inner_stiffness_n_m"),gp=par("x_finger_play","gap_m"); auto stop=[&](D u){return kw*u+(u>gp?2e5*(u-gp):u<-gp?2e5*(u+gp):0);}; D cc=250; D vxn=(-tfx-stop(u2.x))/cc,vzn=(-tfz-stop(u2.z))/cc; u2v.x+=.2*(vxn-u2v.x);u2v.z+=.2*(vzn-u2v.z); u2+=dt*u2v; }
   FN[f]=sn;WF[f]=F;WT[f]=T;slipm+=.5*slp; V pc={0,y0,0}; Ft+=F;Mt+=T+cr(pc-d,F); }
  // to world
  V Fw=mul(Rg,Ft),Mw=mul(Rg,Mt);
  // pusher
  V PF,PT; if(st>=0){ V nX={RpN.a.x,RpN.b.x,RpN.c.x},tY={RpN.a.y,RpN.b.y,RpN.c.y},tZ={RpN.a.z,RpN.b.z,RpN.c.z};
   if(!piv){ for(int i=0;i<npx;i++){ V a=mul(R,pp[i]-cm); V pw=x+a; D pen=-dot(nX,pw-po); if(pen<=0){PE[i]=El();continue;} V vp=v+cr(w,a); if(eBend)vp=vp; D fn=kp*(pen-cp*dot(nX,vp)); if(fn<0)fn=0; D dx,dz; ep(PE[i].zx,PE[i].zz,dot(tY,vp),dot(tZ,vp),mupr*fn/kpt,4,dt,dx,dz); V fe=fn*nX+(-kpt*(PE[i].zx+cp*dx))*tY+(-kpt*(PE[i].zz+cp*dz))*tZ; PF+=fe;PT+=cr(pw-po,fe);} }
   else { V oX={R.a.x,R.b.x,R.c.x},oY={R.a.y,R.b.y,R.c.y},oZ={R.a.z,R.b.z,R.c.z}; for(int i=0;i<npx;i++){ V pw=po+mul(RpN,pp[i]); V a=pw-x; V ob=tmul(R,a)+cm; D pen=ob.z+h; if(pen<=0||fabs(ob.x)>L/2||fabs(ob.y)>h){PE[i]=El();continue;} V vp=v+cr(w,a); D fn=kp*(pen-cp*dot(oZ,vp)); if(fn<0)fn=0; D dx,dz; ep(PE[i].zx,PE[i].zz,dot(oX,vp),dot(oY,vp),mupr*fn/kpt,4,dt,dx,dz); V fe=fn*oZ+(-kpt*(PE[i].zx+cp*dx))*oX+(-kpt*(PE[i].zz+cp*dz))*oY; PF+=fe;PT+=cr(pw-po,fe);} }
   if(eBend&&!piv){ D Mb=PT.y-PF.z*.06; pbend+=dt/.005*(-par("x_pusher_bends","rad_per_nm")*Mb-pbend); RpN=mm(Rp,qmat(qv({0,pbend,0}))); } }
  V net=Fw+PF+m*grav; V mom=Mw+PT+cr(po-x,PF);
  V oXw={R.a.x,R.b.x,R.c.x};
  if(efm>0){ D mag=efm-(st>=n0?efk*dot(efu,x-efref):0); V fe=mag*efu; net+=fe; mom+=cr(efat*oXw-mul(R,cm),fe);}
  if(eCab){ D rel=org.x; if(st==0)cabx0=rel; D ky=par("x_cable_clamp","yield_n")/par("x_cable_clamp","stiffness_n_m"); D zc=rel-cabx0-cabz; if(zc>ky){cabz+=zc-ky;zc=ky;}if(zc<-ky){cabz+=zc+ky;zc=-ky;} V fe=mul(Rg,V{-par("x_cable_clamp","stiffness_n_m")*zc,0,0}); net+=fe;mom+=cr(mul(R,V{.5*L,0,0}-cm),fe); }
  // record
  if(st>=n0-per/2){ long k=(st-(n0-per/2))/per; if(k<=ns){ D*a=acc[k].w; addW(a,WF[0],WT[0]);addW(a+6,WF[1],WT[1]);addW(a+12,PF,PT);cntv[k]++; }
   if(t>-.002&&t<S.rest*.95&&t>S.rest*.5){ V b=net; D e=sqrt(dot(b,b)); if(efm==0&&!eCab)maxBal=max(maxBal,e);} }
  if(st%LG==0){ if(lg0<0)lg0=st; lg.push_back({x-mul(R,cm),pg,q,th}); }
  // grip command and jaw
  D Fe=Fc*(1-lf)-lo; if(gg!=0)Fe*=1+gg*Xc; if(wG!=0)Fe+=wG*cos(wk*Xc+wp);
  if(drop!=0||drop1!=0){ if(t>0)slipsum+=dt*slipm; D tg=drop*(1-exp(-.693147*slipm/knee))+drop1*slipsum; lagx+=dt/dtm*(tg-lagx); Fe*=1-lagx; }
  D Fa=S.jawk*(jw-jc); jc-=dt*(Fe-Fa)/(S.jawk*S.jawtau); jv+=dt/mj*(.5*(FN[0]+FN[1])*2-2*Fa-cj*jv*2)*.5; jw+=dt*jv;
  // integrate object
  D damp=st<n0/2?exp(-dt*200):1; v+=(dt/m)*net; v=damp*v; V wo=tmul(R,w),mo=tmul(R,mom); wo+=V{dt*(mo.x-(Iz-Iy)*wo.y*wo.z)/Ix,dt*(mo.y-(Ix-Iz)*wo.z*wo.x)/Iy,dt*(mo.z-(Iy-Ix)*wo.x*wo.y)/Iz}; wo=damp*wo; w=mul(R,wo); x+=dt*v; q=qn(qm(q,Q{1,.5*dt*wo.x,.5*dt*wo.y,.5*dt*wo.z})); R=qmat(q);
  pg+=dt*vg; th+=dt*om;
 }
 if(!(fabs(x.x)<10)){fprintf(stderr,"trial %d diverged\n",idx);exit(3);}
 // sensors
 FILE*o=fopen(file.c_str(),"w"); fprintf(o,"t_s,grip_cmd_n,gripper_x_m,gripper_y_m,gripper_z_m,gripper_qw,gripper_qx,gripper_qy,gripper_qz,object_x_m,object_y_m,object_z_m,object_qw,object_qx,object_qy,object_qz");
 for(int f=1;f<=2;f++)fprintf(o,",finger%d_fx_n,finger%d_fy_n,finger%d_fz_n,finger%d_tx_nm,finger%d_ty_nm,finger%d_tz_nm",f,f,f,f,f,f); fprintf(o,",pusher_fx_n,pusher_fy_n,pusher_fz_n,pusher_tx_nm,pusher_ty_nm,pusher_tz_nm\n");
 D lat=par("mocap_latency","latency_s"); D ng=CLEAN?0:1; D col[18]={0}; D lp=0; D ll=0; bool loose=has("x_loose_mount"); const char*sn[3]={"finger1","finger2","pusher"}; Rng rn(seed*7919+idx,5);
 for(int k=0;k<ns;k++){ D t=k*Ts; D W[18]; for(int i=0;i<18;i++)W[i]=acc[k].w[i]/max(1,cntv[k]);
  auto at=[&](D tt){ D fi=((tt+tset)/dt-lg0)/LG; if(fi<0)fi=0; if(fi>lg.size()-1.001)fi=lg.size()-1.001; size_t i=size_t(fi);D u=fi-i; Log a=lg[i],b=lg[i+1]; Log c2; c2.p=a.p+u*(b.p-a.p);c2.g=a.g+u*(b.g-a.g);c2.th=a.th+u*(b.th-a.th);c2.q=qn({a.q.w+u*(b.q.w-a.q.w),a.q.x+u*(b.q.x-a.q.x),a.q.y+u*(b.q.y-a.q.y),a.q.z+u*(b.q.z-a.q.z)});return c2;};
  D ck=CLEAN?0:S.clock; Log G=at(t+ck),O=at(t+ck-lat);
  for(int s=0;s<3;s++){ D*a=W+6*s; V f={a[0],a[1],a[2]},tq={a[3],a[4],a[5]};
   string b=sn[s]; V mr={par("sensor_misalignment",(b+"_x_rad").c_str()),par("sensor_misalignment",(b+"_y_rad").c_str()),par("sensor_misalignment",(b+"_z_rad").c_str())};
   if(loose&&int(par("x_loose_mount","finger"))==s+1){ D tr_=par("x_loose_mount","threshold_n"); D dx=f.x-lp; if(dx>tr_){lp=f.x-tr_;}else if(dx<-tr_){lp=f.x+tr_;} ll=tanh(lp/tr_); mr.z+=par("x_loose_mount","play_rad")*ll; }
   M Rm=qmat(qv((-1.)*(mr+ng*S.turn[s]))); f=mul(Rm,f);tq=mul(Rm,tq); D gn=1+par("sensor_gain",sn[s]); f=gn*f;tq=gn*tq;
   D in[6]={f.x,f.y,f.z,tq.x,tq.y,tq.z},ou[6]; for(int i=0;i<6;i++){ou[i]=in[i];for(int j=0;j<6;j++)ou[i]+=ng*S.xt[s][i*6+j]*in[j];}
   auto ct2=[&](const char*e){return par("sensor_crosstalk",(b+e).c_str());};
   if(s<2){D N=f.y;ou[0]+=ct2("_to_x")*N;ou[2]+=ct2("_to_z")*N;ou[3]+=ct2("_to_tx_m")*N;ou[4]+=ct2("_to_ty_m")*N;ou[5]+=ct2("_to_tz_m")*N;}else{D N=f.x;ou[1]+=ct2("_to_y")*N;ou[2]+=ct2("_to_z")*N;ou[3]+=ct2("_to_tx_m")*N;ou[4]+=ct2("_to_ty_m")*N;ou[5]+=ct2("_to_tz_m")*N;}
   const char*ch[6]={"_fx_n","_fy_n","_fz_n","_tx_nm","_ty_nm","_tz_nm"};
   for(int i=0;i<6;i++){ D sd=s<2?(i<3?S.fnoise:S.tnoise):(i<3?S.pfn:S.ptn); int z=s*6+i; col[z]=.9*col[z]+sqrt(1-.81)*rn.n(); a[i]=ou[i]+par("sensor_bias",(b+ch[i]).c_str())+ng*(S.bias[z]+sd*(.9*rn.n()+.43589*col[z])); } }
  Q gq=qv({0,G.th,0}); V rnz={S.rotn*rn.n()*ng,S.rotn*rn.n()*ng,S.rotn*rn.n()*ng}; Q oq=qm(O.q,qv(rnz)); V pn={S.posn*rn.n()*ng,S.posn*rn.n()*ng,S.posn*rn.n()*ng}; V op=O.p+pn;
  fprintf(o,"%.6g,%g,%.8g,%.8g,%.8g,%.9g,%.9g,%.9g,%.9g,%.7g,%.7g,%.7g,%.8g,%.7g,%.7g,%.7g",t,c.grip,G.g.x,G.g.y,G.g.z,gq.w,gq.x,gq.y,gq.z,op.x,op.y,op.z,oq.w,oq.x,oq.y,oq.z); for(int i=0;i<18;i++)fprintf(o,",%.6g",W[i]); fputc('\n',o); }
 fclose(o);
}
int main(int ac,char**av){ if(ac<6)return 1; int num=atoi(av[1]);uint64_t seed=strtoull(av[2],0,10);string es=av[3],dir=av[4],key=av[5]; if(ac>6)DT=atof(av[6])*1e-6; if(ac>7)CLEAN=!strcmp(av[7],"clean");
 if(es!="none"){size_t i=0;while(i<=es.size()){size_t j=es.find(',',i);if(j==string::npos)j=es.size();has_.insert(es.substr(i,j-i));i=j+1;}}
 plan(seed); { Set a=S; drawEffects(seed); (void)a; S=Set();pad[0]=pad[1]=Pad(); plan(seed);}
 if(has("torsional_friction")&&!S.hasPivot){fprintf(stderr,"no pivots: torsional_friction cannot act\n");return 4;}
 { int cx=0;for(auto&c:S.conds)cx+=!c.pivot; if(cx<4){fprintf(stderr,"few pushes\n");return 4;} }
 if((int)S.order.size()<24||S.order.size()>60){fprintf(stderr,"trials %zu\n",S.order.size());return 4;}
 if(num==0){printf("K %g Kn %g Kp %g mass %g muf %g piv %d n %d pauses %d eff",S.K,S.Kn,S.Kp,S.mass,S.muf,S.hasPivot,S.nel,S.pausing);for(auto&e:eff)for(auto&p:e.second)printf(" %s=%g",p.first.c_str(),p.second);puts("");return 0;}
 mkdir(dir.c_str(),0755);mkdir((dir+"/trials").c_str(),0755);
 FILE*o=fopen((dir+"/dataset.toml").c_str(),"w"); fprintf(o,"format = \"stickslip-dataset/1\"\nname = \"set%d\"\nsample_rate_hz = %.1f\ngravity_m_s2 = [0.0, 0.0, -9.81]\n\n[[objects]]\nid = \"prism\"\nshape = \"prism\"\nlength_m = %g\nside_m = %g\nmass_kg = %g\n\n[fingers]\ncontact = \"disc\"\ndiameter_m = %g\n\n[pushers.linear_push]\ncontact = \"plane\"\n",num,S.sr,S.L,S.side,S.mass,S.Dp);
 if(S.hasPivot)fprintf(o,"\n[pushers.pivot]\ncontact = \"line\"\nlength_m = %g\n",S.linelen);
 fprintf(o,"\n[sensors.finger]\nforce_noise_n = %g\nforce_uncertainty_n = %g\ntorque_noise_nm = %g\ntorque_uncertainty_nm = %g\n\n[sensors.pusher]\nforce_noise_n = %g\nforce_uncertainty_n = %g\ntorque_noise_nm = %g\ntorque_uncertainty_nm = %g\n\n[sensors.pose]\nposition_noise_m = %g\nrotation_noise_rad = %g\n",S.fnoise,S.func,S.tnoise,S.tunc,S.pfn,S.pfu,S.ptn,S.ptu,S.posn,S.rotn); fclose(o);
 o=fopen((dir+"/trials.csv").c_str(),"w"); fprintf(o,"trial,file,object,primitive,grip_n,speed_m_s,speed_rad_s,slope_rad,pusher_offset_m,run,pusher_x_m,pusher_y_m,pusher_z_m,pusher_qw,pusher_qx,pusher_qy,pusher_qz\n");
 D hum=0; Rng rh(seed,77); D hs=par("x_humid_run","sd"),hr=par("x_humid_run","rho"); hum=hs*rh.n();
 for(size_t i=0;i<S.order.size();i++){ char nm[32];snprintf(nm,32,"t%04zu",i); V p;Q q; if(hs>0)hum=hr*hum+sqrt(1-hr*hr)*hs*rh.n(); trial(seed,i,S.order[i],exp(hum),dir+"/trials/"+nm+".csv",p,q); const Cond&c=S.conds[S.order[i].cond];
  fprintf(o,"%s,trials/%s.csv,prism,%s,%g,",nm,nm,c.pivot?"pivot":"linear_push",c.grip); if(c.pivot)fprintf(o,",%g,,%g",c.speed,c.off);else fprintf(o,"%g,,%g,",c.speed,c.slope); fprintf(o,",%d,%.9g,%.9g,%.9g,%.9g,%g,%.9g,%g\n",S.order[i].run,p.x,p.y,p.z,q.w,q.x,q.y,q.z); }
 fclose(o);
 o=fopen(key.c_str(),"w"); fprintf(o,"{\"number\":%d,\"seed\":%llu,\"effects\":[",num,(unsigned long long)seed); bool f1=true; for(auto&e:eff){fprintf(o,"%s{\"id\":\"%s\",\"params\":{",f1?"":",",e.first.c_str());f1=false;bool f2=true;for(auto&p:e.second){fprintf(o,"%s\"%s\":%.6g",f2?"":",",p.first.c_str(),p.second);f2=false;}fprintf(o,"}}");}
 fprintf(o,"],\n\"mu_finger\":%.5g,\"mu_pusher\":%.5g,\"pad_tangential_n_m\":%.5g,\"pad_normal_n_m\":%.5g,\"pad_stiffening\":%g,\"pusher_n_m\":%.5g,\"friction_scatter\":%.4g,\"torsion_radius_m\":%.5g,\"elements\":%d,\"bristle_exponent\":%d,\"creep_1_s\":%.4g,\"jaw_n_m\":%.5g,\"jaw_lag_s\":%.4g,\"grip_reference_n\":%.4g,\"clock_s\":%.4g,\"pauses\":%s,\"rest_s\":%.4g,\"trials\":%zu,\"conditions\":%zu,\"pivots\":%s,\"max_rest_imbalance_n\":%.3g,\n\"conventions\":\"face_waviness: 1+A cos(2 pi X/lambda + phase), X of the gripper's middle in object axes; gradients from the object's middle; misalignment: sensor axes turned by +angle (reading = R^T F); crosstalk: share of signed fy (fingers), fx (pusher); gravity_tilt: gravity vector turned by +angle\"}\n",S.muf,S.mup,S.K,S.Kn,S.stiffExp,S.Kp,S.scatter,1.5*S.torArm,S.nel,S.dahl,S.creep,S.jawk,S.jawtau,S.Nref,S.clock,S.pausing?"true":"false",S.rest,S.order.size(),S.conds.size(),S.hasPivot?"true":"false",maxBal); fclose(o); return 0; }
