// sim6: explicit (symplectic) Winkler-column simulator of the gripper bench.  ./sim6 NNN SEED EFFECTS SETDIR KEY
// environment (checks only): SIM6_CLEAN=1 no sensor errors, SIM6_HDIV=n divides the step, SIM6_MAXTRIALS=n, SIM6_HOLD=1 no motion
#include <cstdio>
#include <cstdlib>
#include <cmath>
#include <cstring>
#include <string>
#include <vector>
#include <map>
#include <array>
#include <random>
#include <algorithm>
#include <sys/stat.h>
using namespace std;
typedef double D;
struct V{D x,y,z;};
static inline V operator+(V a,V b){return{a.x+b.x,a.y+b.y,a.z+b.z};}
static inline V operator-(V a,V b){return{a.x-b.x,a.y-b.y,a.z-b.z};}
static inline V operator*(D s,V a){return{s*a.x,s*a.y,s*a.z};}
static inline void operator+=(V&a,V b){a.x+=b.x;a.y+=b.y;a.z+=b.z;}
static inline D dot(V a,V b){return a.x*b.x+a.y*b.y+a.z*b.z;}
static inline V cr(V a,V b){return{a.y*b.z-a.z*b.y,a.z*b.x-a.x*b.z,a.x*b.y-a.y*b.x};}
struct M{D m[3][3];};
static inline V mul(const M&A,V v){return{A.m[0][0]*v.x+A.m[0][1]*v.y+A.m[0][2]*v.z,A.m[1][0]*v.x+A.m[1][1]*v.y+A.m[1][2]*v.z,A.m[2][0]*v.x+A.m[2][1]*v.y+A.m[2][2]*v.z};}
static inline V mulT(const M&A,V v){return{A.m[0][0]*v.x+A.m[1][0]*v.y+A.m[2][0]*v.z,A.m[0][1]*v.x+A.m[1][1]*v.y+A.m[2][1]*v.z,A.m[0][2]*v.x+A.m[1][2]*v.y+A.m[2][2]*v.z};}
struct Q{D w,x,y,z;};
static inline Q qm(Q a,Q b){return{a.w*b.w-a.x*b.x-a.y*b.y-a.z*b.z,a.w*b.x+a.x*b.w+a.y*b.z-a.z*b.y,a.w*b.y-a.x*b.z+a.y*b.w+a.z*b.x,a.w*b.z+a.x*b.y-a.y*b.x+a.z*b.w};}
static inline Q qn(Q a){D n=1/sqrt(a.w*a.w+a.x*a.x+a.y*a.y+a.z*a.z);return{a.w*n,a.x*n,a.y*n,a.z*n};}
static inline Q qe(V r){D t=sqrt(dot(r,r));D s=t<1e-6?0.5-t*t/48:sin(t/2)/t;return{cos(t/2),s*r.x,s*r.y,s*r.z};}
static inline M qR(Q q){D w=q.w,x=q.x,y=q.y,z=q.z;return{{{1-2*(y*y+z*z),2*(x*y-w*z),2*(x*z+w*y)},{2*(x*y+w*z),1-2*(x*x+z*z),2*(y*z-w*x)},{2*(x*z-w*y),2*(y*z+w*x),1-2*(x*x+y*y)}}};}

struct R{ mt19937_64 g; R(uint64_t s):g(s*0x9E3779B97F4A7C15ull+12345){for(int i=0;i<10;i++)g();}
  D u(D a,D b){return a+(b-a)*((g()>>11)*(1.0/9007199254740992.0));}
  D lu(D a,D b){return exp(u(log(a),log(b)));}
  D n(){D s=u(1e-300,1),t=u(0,2*M_PI);return sqrt(-2*log(s))*cos(t);}
  int i(int n){return (int)(g()%n);} D sg(){return (g()>>20)&1?1:-1;} bool p(D q){return u(0,1)<q;} };

// ------------- effects (neutral values)
struct Eff{
 D st_ex=0,st_v=0.002,visc=0,dw=0,dw_cut=0.05,dw_ren=2e-5,load=0,aniso=1,mism=0,wear=0,tors=0,pox=0,poz=0,
 slope=0,fgrad=0,setup=0,wav=0,wavl=0.008,wavph=0,ppitch=0,pyaw=0,adh=0,gfrac=0,goff=0,ldrop=0,ltime=0,lknee=1e-3,lsharp=1,ldrop1=0,
 mfrac=0,mcom=0,ex=0,ey=0,ez=0,ek=0,eat=0,gtx=0,gty=0,lat=0,
 x_bl=0,x_filmA=0,x_filmD=0.002,x_hoseF=0,x_hosek=0,x_heat=0,x_cool=0.5,x_skinF=0,x_skind=0,x_self=0,x_skew=0,x_hyst=0,x_pcreep=0;
 D bias[18]={0},gain[3]={0},mis[3][3]={{0}},xt[3][5]={{0}}; // xt: finger: to x, to z, tx, ty, tz ; pusher: to y, to z, ...
} E;
map<string,D> strengths;
static D has(const vector<string>&e,const char*s){return find(e.begin(),e.end(),string(s))!=e.end();}

struct Trial{int prim;D grip,speed,slope,off;int run;D travel;D px,py,pz;Q pq;string key;};
// ------------- set
struct Set{
 D rate,L,side,mass,dia,kn,kt,mu,mup,x0,noiseF,uncF,noiseT,uncT,noiseFp,uncFp,noiseTp,uncTp,npos,nrot,fs;
 int pushC,pivC; D lineP,lineV,tipP,tipV,edge,gap; vector<D> grips,speeds,slopes,offs,wsp; bool doPush,doPiv; D slide,ang; int reps; D pushz;
 D zetap,taud,phi,tauc,kw,krw,mg,ig,ks,mj,fl,delay,stic,kstr,mstr,kp,h,scat,scatf,scatp,taus,latn,place; int ncol;
} S;
static const D PI2=2*M_PI;
struct Pad{vector<D> x,z,k,kt,prof,mu; vector<D> zc,ex,ez,cx,cz,vf,age,sl; };
struct PadMap{D tx,tz;vector<D> k;} pm[2];
struct Pose{float t;D p[7];D g[7];};
static D bump(D t,D T,D a){ // smooth ramp: position of a unit-speed move of duration T with raised cosine ramps a
  if(t<=0)return 0; if(t>=T)t=T; auto r=[&](D s){return s/2-a/PI2*sin(M_PI*s/a);};
  if(t<a)return r(t); if(t<T-a)return a/2+(t-a); return (T-a)-r(T-t);}

int main(int argc,char**argv){
 if(argc<6){fprintf(stderr,"usage\n");return 1;}
 int num=atoi(argv[1]);uint64_t seed=strtoull(argv[2],0,10);string effs=argv[3],dir=argv[4],keyf=argv[5];
 bool clean=getenv("SIM6_CLEAN"),hold=getenv("SIM6_HOLD");int hdiv=getenv("SIM6_HDIV")?atoi(getenv("SIM6_HDIV")):1;int maxT=getenv("SIM6_MAXTRIALS")?atoi(getenv("SIM6_MAXTRIALS")):9999;
 vector<string> ef;{size_t p=0;while(p<=effs.size()){size_t c=effs.find(',',p);if(c==string::npos)c=effs.size();string s=effs.substr(p,c-p);if(s!="none"&&s!="")ef.push_back(s);p=c+1;}}
 R r(seed);
 // ---------------- design
 for(int tries=0;;tries++){
  S.grips.clear();S.speeds.clear();S.slopes.clear();S.offs.clear();S.wsp.clear();
  int type=r.i(4); // 0 pushes only, 1,2 both, 3 mostly pivots
  S.doPush=true;S.doPiv=type!=0; if(type==3)S.doPush=r.p(0.6);
  int ng=type==0?2+r.i(4):2+r.i(2); D g0=r.lu(8,26),g1=min(60.0,g0*r.u(1.6,2.6)); for(int i=0;i<ng;i++){D g=g0*pow(g1/g0,(D)i/(ng-1));S.grips.push_back(g<20?round(g*2)/2:round(g));}
  int ns=1+r.i(3); D s0=r.lu(2,10),s1=min(40.0,s0*r.u(2.5,6)); for(int i=0;i<ns;i++){D s=ns==1?r.lu(4,20):s0*pow(s1/s0,(D)i/(ns-1));S.speeds.push_back((s<10?round(s*2)/2:round(s))*1e-3);}
  int nl=2+r.i(2); D sl=r.u(8,25); if(r.p(0.5)){ if(nl==2){S.slopes={0,round(sl)*r.sg()};} else S.slopes={-round(sl),0,round(sl)};} else {if(nl==2)S.slopes={-round(sl),round(sl)};else S.slopes={0,round(sl/2)*r.sg(),0};if(nl==3)S.slopes[2]=S.slopes[1]*2;} for(D&x:S.slopes)x*=M_PI/180;
  if(type==3){S.slopes.resize(1+r.i(2));}
  S.mu=r.lu(0.25,1.1);S.mup=r.lu(0.12,0.5);S.dia=round(r.u(8,25)*2)/2*1e-3;D a=S.dia/2;
  S.kn=r.lu(2e4,2e6);S.kt=S.kn*r.u(0.3,0.8);
  S.side=round(r.u(20,60))*1e-3;S.L=round(max(r.u(25,80)*1e-3,S.side*r.u(0.9,1.6))*1e3)*1e-3;if(S.L>0.08||S.L<0.025)continue;
  S.slide=r.u(5,11)*1e-3; D smax=0;for(D s:S.slopes)smax=max(smax,fabs(sin(s)));
  S.x0=r.p(0.4)?round(r.u(-5,3))*1e-3:0;
  D pre=1.1*S.mu*g1/S.kt; S.slide+=min(1.2*pre,2e-3);
  S.mass=S.L*S.side*S.side*r.u(900,2800); S.mass=min(max(S.mass,0.06),0.6);S.mass=round(S.mass*1e4)/1e4;
  if(S.mass*9.81*3>2*S.mu*S.grips[0])continue; 
  // clearances
  D mar=1.5e-3+0.3e-3; D am=a; D eo=has(ef,"pressure_offset")?6e-3:0; if(has(ef,"torsional_friction"))am=a*1.3;
  if(S.doPush&&S.L/2-am-fabs(S.x0)-S.slide-mar-eo*0.6<0)continue;
  if(S.side/2-am-(S.doPush?S.slide*smax:0)-mar-1.0e-3-eo*0.4<0)continue;
  S.edge=round(r.u(3,6))*1e-3; D lever=S.L/2-S.edge-S.x0; 
  if(S.doPiv){ if(lever<1.7*a)continue; D room=lever-1.4*a; S.offs={0}; int no=1+r.i(2); if(no==2&&room>3e-3)S.offs.push_back(round(min(room,r.u(3,15)*1e-3)*1e3)/1e3);
   int nw=1+r.i(2);D w0=r.lu(3,8);S.wsp.push_back(round(w0)*M_PI/180);if(nw==2)S.wsp.push_back(round(w0*r.u(2,3.5))*M_PI/180); S.ang=r.u(10,22)*M_PI/180;}
  S.pushC=r.p(0.75)?0:1; S.pivC=r.p(0.7)?1:2;
  S.reps=2+r.i(2);
  int np=S.doPush?(int)(S.grips.size()*S.speeds.size()*S.slopes.size()):0, nv=S.doPiv?(int)(S.grips.size()*S.offs.size()*S.wsp.size()):0;
  int nt=(np+nv)*S.reps; if(nt<30||nt>80)continue;
  // what an effect needs to show
  bool bad=false; auto H=[&](const char*s){return has(ef,s);};
  if((H("torsional_friction")||H("pressure_offset"))&&!S.doPiv)bad=1; if(H("torsional_friction")&&S.dia<0.014)bad=1;
  if(H("plate_tilt")&&(!S.doPush||S.pushC!=0))bad=1;
  if((H("load_dependent_friction")||H("adhesion")||H("grip_force_loss")||H("x_self_energising"))&&S.grips.size()<3)bad=1;
  if((H("viscous_friction")||H("static_friction")||H("grip_force_lag")||H("x_clock_skew"))&&(!S.doPush||S.speeds.size()<2))bad=1;
  if((H("anisotropic_friction")||H("face_tilt")||H("face_waviness")||H("x_skin_slip")||H("x_backlash")||H("x_film")||H("x_hose")||H("x_heating")||H("x_self_energising")||H("x_plate_creep")||H("finger_friction_mismatch"))&&!S.doPush)bad=1;
  if(H("anisotropic_friction")&&!S.doPiv&&smax<0.17)bad=1;
  if(bad)continue;
  break;}
 D a=S.dia/2;
 S.rate=r.p(0.6)?250:(r.p(0.5)?500:200);
 S.noiseF=r.lu(0.01,0.1);S.noiseT=S.noiseF*r.u(0.008,0.02);S.uncF=r.lu(0.06,0.3);S.uncT=S.uncF*r.u(0.008,0.015);
 S.noiseFp=S.noiseF*r.u(1,2);S.noiseTp=S.noiseFp*r.u(0.02,0.05);S.uncFp=S.uncF*r.u(1,3);S.uncTp=S.uncFp*r.u(0.02,0.05);
 auto r2=[](D v){D e=pow(10,floor(log10(v))-1);return round(v/e)*e;};
 for(D*p:{&S.noiseF,&S.noiseT,&S.uncF,&S.uncT,&S.noiseFp,&S.noiseTp,&S.uncFp,&S.uncTp})*p=r2(*p);
 S.npos=r2(r.lu(1e-5,1e-4));S.nrot=r2(S.npos/r.u(0.06,0.15));
 S.lineP=round(min(S.side*1.1,r.u(18,50)*1e-3)*1e3)/1e3;S.lineV=round(min(S.side*1.1,r.u(15,50)*1e-3)*1e3)/1e3;S.tipP=0.004;S.tipV=round(r.u(3,8))*1e-3;
 S.gap=round(r.u(0.3,1.2)*10)*1e-4; S.pushz=(S.pushC==1&&r.p(0.5))?round(r.u(-2,2))*1e-3:0;
 S.phi=r.u(0.005,0.05);S.tauc=r.u(0.3,2);
 S.mg=r.u(1,2.5);S.kw=r.lu(2e5,1.5e6);S.krw=r.lu(600,4000);S.ig=S.mg*r.u(0.002,0.004);
 S.ks=r.lu(3e4,2e5);S.mj=r.u(0.2,0.6);S.fl=r.u(1.5,4);S.delay=r.u(0.005,0.02);S.stic=r.u(0.001,0.004);
 S.kstr=r.lu(2e6,1.5e7);S.mstr=r.u(2,5);S.kp=min(r.lu(8e5,4e6),1.2e8*0.1*S.mass*2);
 S.scat=r.u(0.01,0.05);S.scatf=r.u(0.003,0.01);S.scatp=r.u(0.01,0.04);S.taus=r.u(0.5e-3,1.2e-3);S.latn=r.u(0,1.8e-3);S.place=r.u(1e-4,2.5e-4);
 S.ncol=72;
 D wmax=sqrt((2*S.kn+S.kp)/S.mass);wmax=max(wmax,sqrt(2*S.kn/min(S.mj,S.mass)*1.2));
 {D Iy=S.mass*(S.L*S.L+S.side*S.side)/12,Ix=S.mass*S.side*S.side/6; wmax=max(wmax,sqrt((2*S.kt*a*a/2+S.kp*S.L*S.L/4)/Iy));wmax=max(wmax,sqrt((2*S.kn*a*a/4+2*S.kt*S.side*S.side/4)/Ix));}
 S.h=min(1e-4,0.35/wmax);S.h=1.0/(S.rate*ceil(1.0/(S.rate*S.h)));S.h/=hdiv;
 {D Iy=S.mass*(S.L*S.L+S.side*S.side)/12;D wl=min(sqrt(2*S.kt/S.mass),sqrt(S.kt*a*a/Iy));S.taud=min(2*r.u(0.06,0.15)/wl,0.9/wmax);}
 // ---------------- effects
 auto str=[&](D typ,bool sign=true){D f=r.lu(0.5,3);return typ*f*(sign?r.sg():1);};
 auto put=[&](const char*n,D&v,D val){v=val;strengths[n]=val;};
 vector<string> chn={"fx_n","fy_n","fz_n","tx_nm","ty_nm","tz_nm"};
 const char* sen[3]={"finger1","finger2","pusher"};
 for(auto&s:ef){
  if(s=="static_friction"){put("static_friction.excess",E.st_ex,str(0.2,false));put("static_friction.stribeck_speed_m_s",E.st_v,str(0.002,false));}
  else if(s=="viscous_friction")put("viscous_friction.viscosity_s_m",E.visc,max(str(2.0),-1.5));
  else if(s=="dwell_strengthening"){put("dwell_strengthening.strengthening",E.dw,str(0.05,false));put("dwell_strengthening.cutoff_s",E.dw_cut,0.05);put("dwell_strengthening.renewal_m",E.dw_ren,str(2e-5,false));}
  else if(s=="load_dependent_friction")put("load_dependent_friction.exponent",E.load,str(0.15));
  else if(s=="anisotropic_friction"){D l=min(str(log(1.4),false),0.8)*r.sg();put("anisotropic_friction.ratio",E.aniso,exp(l));}
  else if(s=="finger_friction_mismatch")put("finger_friction_mismatch.mismatch",E.mism,str(0.15));
  else if(s=="wear_drift")put("wear_drift.rate_per_trial",E.wear,str(-0.0006*r.u(1,1)));
  else if(s=="torsional_friction"){D m=0.3*2/3*a;put("torsional_friction.radius_change_m",E.tors,min(str(0.002,false),m)*r.sg());}
  else if(s=="pressure_offset"){put("pressure_offset.offset_x_m",E.pox,max(-3.6e-3,min(3.6e-3,str(0.002))));put("pressure_offset.offset_z_m",E.poz,max(-2.4e-3,min(2.4e-3,str(0.001))));}
  else if(s=="face_tilt"){ if(r.p(0.5)){put("face_tilt.slope_rad",E.slope,str(0.01));E.setup=S.kn*fabs(E.slope)*a*a/4>0.2*a*S.grips[0];strengths["face_tilt.set_up"]=E.setup;} else put("face_tilt.friction_gradient_1_m",E.fgrad,str(6));}
  else if(s=="face_waviness"){D lam=max(str(0.008,false),1.5*S.dia);put("face_waviness.amplitude",E.wav,str(0.1));put("face_waviness.wavelength_m",E.wavl,lam);put("face_waviness.phase_rad",E.wavph,r.u(-3.1,3.1));}
  else if(s=="plate_tilt"){put("plate_tilt.pitch_rad",E.ppitch,str(0.01));put("plate_tilt.yaw_rad",E.pyaw,str(0.01)*0.6);}
  else if(s=="adhesion")put("adhesion.pull_off_n",E.adh,str(1.0,false));
  else if(s=="grip_force_loss"){if(r.p(0.5))put("grip_force_loss.fraction",E.gfrac,str(0.1));else put("grip_force_loss.offset_n",E.goff,min(str(1.0),0.3*S.grips[0]));}
  else if(s=="grip_force_lag"){put("grip_force_lag.drop",E.ldrop,str(0.12));put("grip_force_lag.time_s",E.ltime,str(0.1,false));put("grip_force_lag.knee_m_s",E.lknee,str(1e-3,false));}
  else if(s=="mass_error"){put("mass_error.fraction",E.mfrac,str(0.1));if(r.p(0.6))put("mass_error.com_x_m",E.mcom,max(-S.L/5,min(S.L/5,str(0.004))));}
  else if(s=="external_force"){put("external_force.x_n",E.ex,str(0.5));if(r.p(0.6))put("external_force.y_n",E.ey,str(0.5));put("external_force.z_n",E.ez,str(0.5));if(r.p(0.5))put("external_force.stiffness_n_m",E.ek,str(20));}
  else if(s=="gravity_tilt"){put("gravity_tilt.about_x_rad",E.gtx,str(0.05));put("gravity_tilt.about_y_rad",E.gty,str(0.05));}
  else if(s=="sensor_bias"){for(int m=0;m<1+r.i(2);m++){int k=r.i(3),c=r.i(6);string n=string("sensor_bias.")+sen[k]+"_"+chn[c];put(n.c_str(),E.bias[6*k+c],str(c<3?0.25:0.003)*(k==2?2:1));}}
  else if(s=="sensor_gain"){int k=r.i(3);put((string("sensor_gain.")+sen[k]).c_str(),E.gain[k],str(0.05));}
  else if(s=="sensor_misalignment"){int k=r.i(3),c=k==2?1+r.i(2):2*r.i(2);put((string("sensor_misalignment.")+sen[k]+"_"+"xyz"[c]+"_rad").c_str(),E.mis[k][c],str(0.03));}
  else if(s=="sensor_crosstalk"){int k=r.i(3);const char*nf[5]={"_to_x","_to_z","_to_tx_m","_to_ty_m","_to_tz_m"};const char*np[5]={"_to_y","_to_z","_to_tx_m","_to_ty_m","_to_tz_m"};int c=r.i(k==2?2:5);put((string("sensor_crosstalk.")+sen[k]+(k==2?np[c]:nf[c])).c_str(),E.xt[k][c],str(c<2?0.02:0.0005));}
  else if(s=="mocap_latency")put("mocap_latency.latency_s",E.lat,str(0.02));
  else if(s=="x_backlash")put("x_backlash.half_play_m",E.x_bl,r.lu(1e-4,5e-4));
  else if(s=="x_film"){put("x_film.force_n",E.x_filmA,r.lu(0.1,0.35)*S.mu*S.grips[0]);put("x_film.distance_m",E.x_filmD,r.lu(1e-3,5e-3));}
  else if(s=="x_hose"){put("x_hose.force_n",E.x_hoseF,r.lu(0.5,2.5));put("x_hose.stiffness_n_m",E.x_hosek,r.lu(300,2000));}
  else if(s=="x_heating"){put("x_heating.loss_1_j",E.x_heat,r.lu(0.08,0.3)*r.sg()/(S.mu*S.grips[S.grips.size()/2]*S.slide));put("x_heating.kept_between_trials",E.x_cool,r.u(0.1,0.6));}
  else if(s=="x_skin_slip"){put("x_skin_slip.threshold_n",E.x_skinF,r.u(0.4,0.85)*2*S.mu*S.grips[0]);put("x_skin_slip.half_way_m",E.x_skind,r.lu(3e-4,1.2e-3));}
  else if(s=="x_self_energising")put("x_self_energising.gain",E.x_self,r.lu(0.08,0.3)*r.sg());
  else if(s=="x_clock_skew")put("x_clock_skew.rate_s_s",E.x_skew,r.lu(0.004,0.015)*r.sg());
  else if(s=="x_sensor_hysteresis")put("x_sensor_hysteresis.half_width_n",E.x_hyst,r.lu(0.15,0.6));
  else if(s=="x_plate_creep")put("x_plate_creep.mobility_m_s_n",E.x_pcreep,r.lu(0.02,0.1)*0.004/(2*S.mu*S.grips[S.grips.size()/2]));
  else{fprintf(stderr,"unknown effect %s\n",s.c_str());return 1;}
 }
 // ---------------- pads (of the set)
 int N=S.ncol; D ar=a+1.5*E.tors; D tilt=min(1e-3,0.12*S.grips[0]/(S.kn*a)); D sgk=r.u(0.12,0.3),bk=r.u(-0.25,0.25);
 for(int k=0;k<2;k++){pm[k].tx=r.u(-1,1)*tilt;pm[k].tz=r.u(-1,1)*tilt;D sum=0;for(int i=0;i<N;i++){D rho2=(i+0.5)/N;D w=exp(sgk*r.n())*(1+bk*(2*rho2-1));pm[k].k.push_back(w);sum+=w;}for(D&w:pm[k].k)w*=S.kn/sum;}
 // ---------------- sensor constants of the set
 D biasS[18],gains[3],xn[3][2];for(int k=0;k<3;k++){for(int c=0;c<6;c++)biasS[6*k+c]=r.u(-0.6,0.6)*(k<2?(c<3?S.uncF:S.uncT):(c<3?S.uncFp:S.uncTp));gains[k]=r.u(-0.003,0.003);xn[k][0]=r.u(-0.003,0.003);xn[k][1]=r.u(-0.003,0.003);}
 D psq[3]={r.u(-3e-4,3e-4),r.u(-3e-4,3e-4),r.u(-3e-4,3e-4)};D ppo[2]={r.u(-5e-5,5e-5),r.u(-5e-5,5e-5)};
 // ---------------- trials
 vector<Trial> T; {
  vector<Trial> c; bool allrep=r.p(0.6);
  if(S.doPush)for(D g:S.grips)for(D v:S.speeds)for(D s:S.slopes){Trial t;t.prim=0;t.grip=g;t.speed=v;t.slope=s;t.off=S.pushC?S.pushz:0;t.travel=S.gap+min(S.slide,v*3.0+0.002);D tip=S.pushC==2?S.tipP:0;t.px=S.x0-S.L/2-S.gap-tip;t.py=0;t.pz=t.off;t.pq={1,0,0,0};c.push_back(t);}
  if(S.doPiv)for(D g:S.grips)for(D w:S.wsp)for(D o:S.offs){Trial t;t.prim=1;t.grip=g;t.speed=w;t.slope=0;t.off=o;t.travel=min(S.ang,w*3.2);D tip=S.pivC==2?S.tipV:0;t.px=S.x0-(S.L/2-S.edge)+o;t.py=0;t.pz=-S.side/2-tip-min(S.gap,4e-4);t.pq={sqrt(0.5),0,-sqrt(0.5),0};c.push_back(t);}
  bool blocks=r.p(0.4);
  for(int k=0;k<S.reps;k++){vector<Trial> b;for(auto&t:c){Trial u=t;u.run=k;if(!allrep&&k==S.reps-1&&r.p(0.35))continue;b.push_back(u);}for(size_t i=b.size();i>1;i--)swap(b[i-1],b[r.i(i)]);T.insert(T.end(),b.begin(),b.end());}
  if(T.size()<30){T.clear();for(int k=0;k<S.reps;k++){vector<Trial> b;for(auto&t:c){Trial u=t;u.run=k;b.push_back(u);}for(size_t i=b.size();i>1;i--)swap(b[i-1],b[r.i(i)]);T.insert(T.end(),b.begin(),b.end());}}
  if(!blocks)for(size_t i=T.size();i>1;i--)swap(T[i-1],T[r.i(i)]);
 }
 mkdir(dir.c_str(),0755);mkdir((dir+"/trials").c_str(),0755);
 {FILE*f=fopen((dir+"/dataset.toml").c_str(),"w");fprintf(f,"format = \"stickslip-dataset/1\"\nname = \"bench6-%d\"\nsample_rate_hz = %.1f\ngravity_m_s2 = [0.0, 0.0, -9.81]\n\n[[objects]]\nid = \"box\"\nshape = \"prism\"\nlength_m = %g\nside_m = %g\nmass_kg = %g\n\n[fingers]\ncontact = \"disc\"\ndiameter_m = %g\n",num,S.rate,S.L,S.side,S.mass,S.dia);
 if(S.doPush){fprintf(f,"\n[pushers.linear_push]\n");if(S.pushC==0)fprintf(f,"contact = \"plane\"\n");else fprintf(f,"contact = \"line\"\nlength_m = %g\n",S.lineP);}
 if(S.doPiv){fprintf(f,"\n[pushers.pivot]\n");if(S.pivC==1)fprintf(f,"contact = \"line\"\nlength_m = %g\n",S.lineV);else fprintf(f,"contact = \"point\"\ntip_radius_m = %g\n",S.tipV);}
 fprintf(f,"\n[sensors.finger]\nforce_noise_n = %g\nforce_uncertainty_n = %g\ntorque_noise_nm = %g\ntorque_uncertainty_nm = %g\n\n[sensors.pusher]\nforce_noise_n = %g\nforce_uncertainty_n = %g\ntorque_noise_nm = %g\ntorque_uncertainty_nm = %g\n\n[sensors.pose]\nposition_noise_m = %g\nrotation_noise_rad = %g\n",S.noiseF,S.uncF,S.noiseT,S.uncT,S.noiseFp,S.uncFp,S.noiseTp,S.uncTp,S.npos,S.nrot);fclose(f);}
 FILE*ft=fopen((dir+"/trials.csv").c_str(),"w");fprintf(ft,"trial,file,object,primitive,grip_n,speed_m_s,speed_rad_s,slope_rad,pusher_offset_m,run,pusher_x_m,pusher_y_m,pusher_z_m,pusher_qw,pusher_qx,pusher_qy,pusher_qz\n");
 D rw[18]={0},heatT[2]={0,0};D minclear=1,maxsag=0,maxrot=0;int dropped=0;vector<D> muT,mu1T,mu2T;
 for(size_t it=0;it<T.size()&&(int)it<maxT;it++){
  Trial&t=T[it];R q(seed*1000003ull+it*7919ull+17);char id[32];snprintf(id,32,"t%04d",(int)it);
  fprintf(ft,"%s,trials/%s.csv,box,%s,%g,",id,id,t.prim?"pivot":"linear_push",t.grip);
  if(t.prim==0)fprintf(ft,"%g,,%.6g,%s,%d,",t.speed,t.slope,S.pushC?to_string(t.off).c_str():"",t.run);else fprintf(ft,",%.6g,,%g,%d,",t.speed,t.off,t.run);
  fprintf(ft,"%.6g,%.6g,%.6g,%.9g,%.9g,%.9g,%.9g\n",t.px,t.py,t.pz,t.pq.w,t.pq.x,t.pq.y,t.pq.z);
  // --- per trial draws
  D mu0=S.mu*(1+S.scat*q.n())*(1+E.wear*(D)it);D muf[2]={mu0*(1+E.mism)*(1+S.scatf*q.n()),mu0*(1-E.mism)*(1+S.scatf*q.n())};D mup=S.mup*(1+S.scatp*q.n());muT.push_back(mu0);mu1T.push_back(muf[0]);mu2T.push_back(muf[1]);
  D grip=t.grip*(1+0.002*q.n());D ftgt0=grip*(1-E.gfrac)-E.goff;if(clean)ftgt0=t.grip*(1-E.gfrac)-E.goff;
  D pl[3]={S.place*q.n(),S.place*q.n(),3e-4*q.n()};if(fabs(pl[0])>2.5e-4)pl[0]*=0.5;if(fabs(pl[1])>2.5e-4)pl[1]*=0.5;
  D ph1=q.u(0.2,0.35),rest1=q.u(0.2,0.3);
  // --- pads
  Pad P[2];for(int k=0;k<2;k++){Pad&p=P[k];for(int i=0;i<N;i++){D rr=ar*sqrt((i+0.5)/N),th=i*2.399963229728653+k*1.1;D lx=rr*cos(th),lz=rr*sin(th);p.x.push_back(lx+E.pox);p.z.push_back(lz+E.poz);p.k.push_back(pm[k].k[i]);p.kt.push_back(pm[k].k[i]*S.kt/S.kn);p.prof.push_back(pm[k].tx*lx+pm[k].tz*lz+(E.setup?E.slope*lx:0));p.mu.push_back(muf[k]);}
   for(vector<D>*v:{&p.zc,&p.ex,&p.ez,&p.cx,&p.cz,&p.vf,&p.age,&p.sl})v->assign(N,0.0);for(D&x:p.age)x=q.u(0.2,0.4);}
  // --- pusher nodes
  int pc=t.prim==0?S.pushC:S.pivC;struct PN{V r;D k;D ex,ez;bool on;};vector<PN> pn;D hl=t.prim==0?S.lineP/2:S.lineV/2,tip=pc==2?(t.prim?S.tipV:S.tipP):0;
  if(pc==0){int n=7;for(int i=0;i<n;i++)for(int j=0;j<n;j++)pn.push_back({{-S.L/2,S.side/2*(2.0*i/(n-1)-1),S.side/2*(2.0*j/(n-1)-1)},S.kp/n/n,0,0,false});}
  else if(pc==1){int n=11;for(int i=0;i<n;i++)pn.push_back({{0,hl*(2.0*i/(n-1)-1),0},S.kp*0.7/n,0,0,false});}
  else pn.push_back({{0,0,0},S.kp*0.4,0,0,false});
  V rotp={psq[0],psq[1],psq[2]};if(pc==0){rotp.y+=E.ppitch;rotp.z+=E.pyaw;} Q pqt=qm(t.pq,qe(rotp));M RP=qR(pqt);V PO={t.px+ppo[0],t.py,t.pz+ppo[1]};V PN0={t.px,t.py,t.pz};if(t.prim==0&&pc==0)PO.z=t.pz;
  V sd={0,0,0},sv={0,0,0},pcre={0,0,0};
  // --- bodies
  D m=S.mass*(1+E.mfrac);V com={E.mcom,0,0};V I={m*S.side*S.side/6,m*(S.L*S.L+S.side*S.side)/12,m*(S.L*S.L+S.side*S.side)/12};
  V O0={S.x0+pl[0],0,pl[1]};Q oq=qe({0,pl[2],0});M Ro=qR(oq);V x=O0+mul(Ro,com),v={0,0,0},w={0,0,0};
  V g={0,0,-9.81};{M A=qR(qe({E.gtx,0,0})),B=qR(qe({0,E.gty,0}));g=mul(B,mul(A,g));}
  V wd={0,0,0},wv={0,0,0},wr={0,0,0},ww={0,0,0};
  D Nst=ftgt0;D yj=S.side/2-Nst/S.kn+E.slope*(-S.x0),vj=0,cs=yj-Nst/S.ks;
  D blx=0,blv=0,skx=0,skv=0,sks=0,hx=0,hz=0;D lag=1;
  D kl=S.ks*S.kn/(S.ks+S.kn);D h=S.h;int nd=max(1,(int)(S.delay/h));vector<D> buf(nd,Nst);int bi=0;
  D t0=-0.85,acc=min(0.08,0.3*t.travel/t.speed);D Tm=t.travel/t.speed+acc;D tend=ph1+Tm+rest1;if(hold)tend=3;
  long n0=(long)round(t0/h),n1=(long)round(tend/h);int every=(int)round(1/(S.rate*h));
  vector<Pose> tr;tr.reserve(n1-n0+2);
  vector<array<D,18>> fo;vector<D> ts; D lp[18]={0};bool lpi=false;
  D wav0=E.wav;if(E.wav){D ka=PI2/E.wavl*ar;D j=2*j1(ka)/ka;wav0=max(-0.9,min(0.9,E.wav/j));}
  D zz=S.phi/S.tauc;bool dep=E.st_ex||E.dw||E.visc<0;
  D cj=2*0.35*sqrt(S.mj*2*(S.ks+S.kn));cj=min(cj,0.3*S.mj/h);D cw=2*0.15*sqrt(S.kw*S.mg),crw=2*0.15*sqrt(S.krw*S.ig),cst=2*0.1*sqrt(S.kstr*S.mstr);
  D kh=4e4,chh=2*0.5*sqrt(kh*m),krh=40,crh=2*0.4*sqrt(krh*I.x);
  V o0t={0,0,0};bool o0set=false;
  D pref=25.0/N;
  for(long n=n0;n<=n1;n++){
   D tt=n*h;
   // command
   V Gc={0,0,0},Gv={0,0,0};Q Rq={1,0,0,0};V Gw={0,0,0};
   if(!hold){D s=t.speed*bump(tt-ph1,Tm,acc),s2=t.speed*bump(tt+h-ph1,Tm,acc),ds=(s2-s)/h;
    if(t.prim==0){Gc={-s*cos(t.slope),0,s*sin(t.slope)};Gv={-ds*cos(t.slope),0,ds*sin(t.slope)};}else{Rq=qe({0,-s,0});Gw={0,-ds,0};}}
   V G=Gc+wd;V gv=Gv+wv;Q gq=qm(qe(wr),Rq);M Rg=qR(gq);V gw=Gw+ww;
   Ro=qR(oq);V oc=x-mul(Ro,com);V vo=v-cr(w,mul(Ro,com)); // object origin
   // relative kinematics in object axes
   M A;for(int i=0;i<3;i++)for(int j=0;j<3;j++){A.m[i][j]=0;for(int k=0;k<3;k++)A.m[i][j]+=Ro.m[k][i]*Rg.m[k][j];}
   V b=mulT(Ro,G-oc);V wrel=mulT(Ro,gw-w);V a0=mulT(Ro,gv+cr(gw,oc-G)-vo);V Yo={A.m[0][1],A.m[1][1],A.m[2][1]},Xo={A.m[0][0],A.m[1][0],A.m[2][0]};
   V Ft={0,0,0},Mt={0,0,0};V Fk[2],Mk[2];D Nk[2],Qx=0,slipsp=0,qsk=0;
   D cs_=1/sqrt(1+E.slope*E.slope);
   for(int k=0;k<2;k++){
    D s=k==0?1:-1;Pad&p=P[k];V F={0,0,0},MM={0,0,0};V no={-E.slope*cs_,s*cs_,0},t1={cs_,s*E.slope*cs_,0};V av=a0+(s*vj)*Yo;V bo=b; if(k==0&&E.x_bl){bo+=blx*Xo;av+=blv*Xo;}
    if(E.x_skinF)av.x-=skv;
    D NN=0,work=0,sls=0,slw=0;D heat=1-(E.x_heat?E.x_heat*heatT[k]:0);if(heat<0.3)heat=0.3;
    D padh=E.adh/N;
    for(int i=0;i<N;i++){
     V rl={p.x[i],s*(yj+p.prof[i]),p.z[i]};V Po=mul(A,rl)+bo;V vr=av+cr(wrel,Po);
     D hw=S.side/2+E.slope*Po.x;D pen=-(s*Po.y-hw)*cs_;D vn=-dot(vr,no);D vt1=dot(vr,t1),vt2=vr.z;
     D k_=p.k[i];D pr=k_*(pen-p.zc[i])+k_*S.taud*vn;
     if(pr<-padh||pen-p.zc[i]<=-padh/k_){pr=0;p.ex[i]=p.ez[i]=0;p.zc[i]*=1-h/S.tauc;p.cx[i]*=1-h/S.tauc;p.cz[i]*=1-h/S.tauc;continue;}
     D kt=p.kt[i],ct=kt*S.taud;
     p.ex[i]+=h*vt1;p.ez[i]+=h*vt2;
     D q1=kt*(p.ex[i]-p.cx[i])+ct*vt1,q2=kt*(p.ez[i]-p.cz[i])+ct*vt2;
     D mu=p.mu[i]*heat;
     if(E.load&&pr>0)mu*=pow(max(pr,1e-3*pref)/pref,-E.load);
     if(E.fgrad)mu*=1+E.fgrad*Po.x; if(E.wav)mu*=1+wav0*sin(PI2*Po.x/E.wavl+E.wavph);
     if(dep){ if(E.st_ex)mu*=1+E.st_ex*exp(-p.vf[i]/E.st_v); if(E.dw)mu*=1+E.dw*log(1+p.age[i]/E.dw_cut); if(E.visc<0)mu=max(0.2*mu,mu+E.visc*p.vf[i]);}
     D lim=mu*max(0.0,pr+padh);if(E.x_filmA)lim+=E.x_filmA/N*exp(-p.sl[i]/E.x_filmD);
     D vs=0;D r1=1,r2_=1;if(E.aniso!=1){r1=sqrt(E.aniso);r2_=1/r1;}
     D f2=E.aniso!=1?(q1/r1)*(q1/r1)+(q2/r2_)*(q2/r2_):q1*q1+q2*q2;
     if(f2>lim*lim){
      D nq1,nq2,den=kt*h+ct+1e-9;
      if(E.aniso!=1&&lim>0){D la=0;for(int z=0;z<12;z++){D c1=1+la/(r1*r1),c2=1+la/(r2_*r2_);D u1=q1/r1/c1,u2=q2/r2_/c2;D f=u1*u1+u2*u2-lim*lim;D df=-2*(u1*u1/c1/(r1*r1)+u2*u2/c2/(r2_*r2_));D dl=-f/df;la+=dl;if(fabs(dl)<1e-10*(1+la))break;}
       nq1=q1/(1+la/(r1*r1));nq2=q2/(1+la/(r2_*r2_));vs=hypot(q1-nq1,q2-nq2)/den;
       if(E.visc>0){D ve=vs*den/(den+E.visc*max(0.0,pr));D sc=1+E.visc*ve/mu;nq1*=sc;nq2*=sc;vs=ve;}}
      else{D qq=sqrt(f2);D vis=max(0.0,E.visc)*max(0.0,pr);/* d mu/dv = viscosity */
       vs=(qq-lim)/(den+vis+1e-3*lim);D tgt=qq-den*vs;if(tgt<0)tgt=0;nq1=q1*tgt/qq;nq2=q2*tgt/qq;}
      // slip: the anchor follows so that the column bears nq
      p.ex[i]-=h*(q1-nq1)/den;p.ez[i]-=h*(q2-nq2)/den;q1=nq1;q2=nq2;p.sl[i]+=h*vs;work+=h*vs*hypot(q1,q2);
     }
     if(dep){p.vf[i]+=h/0.02*(vs-p.vf[i]);p.age[i]+=h;p.age[i]/=1+h*vs/E.dw_ren;}
     p.zc[i]+=h*(zz*(pen-p.zc[i])-p.zc[i]/S.tauc);p.cx[i]+=h*(zz*(p.ex[i]-p.cx[i])-p.cx[i]/S.tauc);p.cz[i]+=h*(zz*(p.ez[i]-p.cz[i])-p.cz[i]/S.tauc);
     V f={-pr*no.x+q1*t1.x,-pr*no.y+q1*t1.y,q2};V Pc={Po.x,s*hw,Po.z};F+=f;MM+=cr(Pc,f);NN+=pr;sls+=vs*max(pr,0.0);slw+=max(pr,0.0);qsk+=q1;
    }
    heatT[k]+=work;Fk[k]=F;Mk[k]=MM;Nk[k]=NN;Ft+=F;Mt+=MM;slipsp+=slw>0?0.5*sls/slw:0;
   }
   // pusher
   V Fp={0,0,0},Mp={0,0,0};{ // in world, about nominal origin
    V P0=PO+sd+pcre;D taup=S.taud*0.5;
    for(auto&c:pn){V pt,nn,ax1,ax2;D pen;
     if(pc==0){pt=oc+mul(Ro,c.r);nn={RP.m[0][0],RP.m[1][0],RP.m[2][0]};ax1={RP.m[0][1],RP.m[1][1],RP.m[2][1]};ax2={RP.m[0][2],RP.m[1][2],RP.m[2][2]};pen=-dot(pt-P0,nn);if(pen<0&&!c.on)continue;}
     else{V pw=P0+mul(RP,c.r);V po=mulT(Ro,pw-oc);if(fabs(po.y)>S.side/2*1.001){continue;}
      if(t.prim==0){pen=po.x+S.L/2+tip;po.x=-S.L/2;nn={Ro.m[0][0],Ro.m[1][0],Ro.m[2][0]};ax2={Ro.m[0][2],Ro.m[1][2],Ro.m[2][2]};}
      else{pen=po.z+S.side/2+tip;po.z=-S.side/2;nn={Ro.m[0][2],Ro.m[1][2],Ro.m[2][2]};ax2={Ro.m[0][0],Ro.m[1][0],Ro.m[2][0]};}
      ax1={Ro.m[0][1],Ro.m[1][1],Ro.m[2][1]};if(pen<0&&!c.on)continue;pt=oc+mul(Ro,po);}
     V vr=sv-(vo+cr(w,pt-oc));D vn=dot(vr,nn);D pr=c.k*pen+c.k*taup*vn;
     if(pen<=0||pr<=0){c.on=pen>0;c.ex=c.ez=0;continue;} c.on=true;
     D kt=c.k*0.7,ct=kt*taup;c.ex+=h*dot(vr,ax1);c.ez+=h*dot(vr,ax2);D q1=kt*c.ex+ct*dot(vr,ax1),q2=kt*c.ez+ct*dot(vr,ax2);D qq=hypot(q1,q2),lim=mup*pr;
     if(qq>lim){D den=kt*h+ct;D nq1=q1*lim/qq,nq2=q2*lim/qq;c.ex-=h*(q1-nq1)/den;c.ez-=h*(q2-nq2)/den;q1=nq1;q2=nq2;}
     V f=pr*nn+q1*ax1+q2*ax2;Fp+=f;Mp+=cr(pt-PN0,f);}
   }
   // record (forces at t, poses at t)
   {Pose pp;pp.t=tt;pp.p[0]=oc.x;pp.p[1]=oc.y;pp.p[2]=oc.z;pp.p[3]=oq.w;pp.p[4]=oq.x;pp.p[5]=oq.y;pp.p[6]=oq.z;pp.g[0]=G.x;pp.g[1]=G.y;pp.g[2]=G.z;pp.g[3]=gq.w;pp.g[4]=gq.x;pp.g[5]=gq.y;pp.g[6]=gq.z;tr.push_back(pp);}
   {D raw[18];for(int k=0;k<2;k++){D s=k==0?1:-1;D lam=(s*(S.side/2)+s*E.slope*b.x-b.y)/(Yo.y-s*E.slope*Yo.x);V ce=b+lam*Yo;V mo=Mk[k]-cr(ce,Fk[k]);V fg=mulT(A,Fk[k]),mgp=mulT(A,mo);raw[6*k]=fg.x;raw[6*k+1]=fg.y;raw[6*k+2]=fg.z;raw[6*k+3]=mgp.x;raw[6*k+4]=mgp.y;raw[6*k+5]=mgp.z;}
    raw[12]=Fp.x;raw[13]=Fp.y;raw[14]=Fp.z;raw[15]=Mp.x;raw[16]=Mp.y;raw[17]=Mp.z;
    D al=clean?1:1-exp(-h/S.taus);if(!lpi&&tt>-0.1){for(int c=0;c<18;c++)lp[c]=raw[c];lpi=true;}if(lpi)for(int c=0;c<18;c++)lp[c]+=al*(raw[c]-lp[c]);
    if(n>=0&&n%every==0){array<D,18> o;for(int c=0;c<18;c++)o[c]=lp[c];fo.push_back(o);ts.push_back(tt);}}
   // unmeasured loads
   V Fx={0,0,0};V Tx={0,0,0};
   if(tt>=-1e-9&&!o0set){o0t=oc;o0set=true;}
   if(E.ex||E.ey||E.ez||E.ek){V f={E.ex,E.ey,E.ez};if(E.ek&&o0set)f=f-E.ek*(oc-o0t);Fx+=f;V at=mul(Ro,{E.eat,0,0});Tx+=cr(oc+at-x,f);}
   if(E.x_hoseF){V rel=oc-G;static thread_local V last;if(n==n0)last=rel;hx+=rel.x-last.x;hz+=rel.z-last.z;last=rel;D q1=E.x_hosek*hx,q2=E.x_hosek*hz,qq=hypot(q1,q2);if(qq>E.x_hoseF){hx*=E.x_hoseF/qq;hz*=E.x_hoseF/qq;}V f={-E.x_hosek*hx,0,-E.x_hosek*hz};Fx+=f;Tx+=cr(mul(Ro,{S.L/2,0,0})+oc-x,f);}
   if(tt<-0.3){D sc=tt<-0.55?1:0.5-0.5*cos(M_PI*(-0.3-tt)/0.25);V e=oc-O0;V f={-kh*e.x-chh*vo.x,0,-kh*e.z-chh*vo.z};f.z+=0;Fx+=sc*f;V er=2*V{oq.x,oq.y-pl[2]/2,oq.z};V tq={-0.05*krh*er.x-0.3*crh*w.x,-krh*er.y-crh*w.y,-0.05*krh*er.z-0.3*crh*w.z};Tx+=sc*tq;}
   // object
   V Fow=mul(Ro,Ft),Mow=mul(Ro,Mt-cr(com,Ft));
   if(E.x_skinF){ // skin: pads act on the skin along object X, the skin on the core
    D c_=8;sks=sks;D e=skx-sks;D ksk=2e5;D f=ksk*e;if(fabs(f)>E.x_skinF){D o=f>0?E.x_skinF:-E.x_skinF;sks=skx-o/ksk;f=o;}D stp=fabs(skx)>E.x_skind?3e5*(fabs(skx)-E.x_skind)*(skx>0?1:-1):0;D fc=f+stp+c_*skv;D msk=0.02;
    V df={fc-qsk,0,0};Fow+=mul(Ro,df);skv+=h/msk*(qsk-fc);skx+=h*skv;}
   V Fto=Fow+Fp+Fx+m*g;V Tto=Mow+Mp+cr(PN0-x,Fp)+Tx;
   v+=(h/m)*Fto;
   {V wl=mulT(Ro,w),tl=mulT(Ro,Tto);V Iw={I.x*wl.x,I.y*wl.y,I.z*wl.z};V gy=cr(wl,Iw);wl+=V{h*(tl.x-gy.x)/I.x,h*(tl.y-gy.y)/I.y,h*(tl.z-gy.z)/I.z};w=mul(Ro,wl);}
   x+=h*v;oq=qn(qm(qe(h*w),oq));
   // gripper on its wrist
   V Fg=mul(Ro,Ft);V Mg=mul(Ro,Mt)-cr(G-oc,Fg);
   wv+=(h/S.mg)*(-1.0*Fg-S.kw*wd-cw*wv);wd+=h*wv;ww+=(h/S.ig)*(-1.0*Mg-S.krw*wr-crw*ww);wr+=h*ww;
   // pusher's structure
   sv+=(h/S.mstr)*(-1.0*Fp-S.kstr*sd-cst*sv);sd+=h*sv;if(E.x_pcreep)pcre+=(-h*E.x_pcreep)*Fp;
   // jaw: generalised force on the half opening
   D n1=-dot(Fk[0],Yo),n2=dot(Fk[1],Yo);Qx=dot(Fk[0]+Fk[1],Xo);
   D dFs=E.x_self?E.x_self*(-Qx):0;
   D tg=1;if(E.ldrop){D u=pow(slipsp,E.lsharp);tg=1-E.ldrop*u/(u+pow(E.lknee,E.lsharp));}
   if(E.ltime>0)lag+=h/max(E.ltime,h)*(tg-lag);else lag=tg;
   D Fs=S.ks*(yj-cs);vj+=h/S.mj*(n1+n2-2*Fs-dFs-cj*vj);yj+=h*vj;
   D meas=E.x_self?Fs:0.5*(n1+n2);D dm=buf[bi];buf[bi]=meas;bi=(bi+1)%nd;D err=ftgt0*(E.ldrop?lag:1)-dm;
   if(fabs(err)>S.stic*ftgt0)cs-=h*PI2*S.fl*err/kl;
   if(E.x_bl){D fx=dot(Fk[0],Xo);D f=-fx-15*blv;if(fabs(blx)>E.x_bl)f-=2e5*(blx-(blx>0?1:-1)*E.x_bl)+60*blv;blv+=h/0.08*f;blx+=h*blv;}
   // clearance
   if(n%every==0&&tt>=0){for(int k=0;k<1;k++){D cxl=S.L/2-fabs(b.x+E.pox)-ar,czl=S.side/2-fabs(b.z+E.poz)-ar;minclear=min(minclear,min(cxl,czl));maxsag=max(maxsag,fabs(b.z));}if(!(fabs(oc.z)<0.02)||n1<0.05*ftgt0)dropped=1;maxrot=max(maxrot,max(fabs(oq.x),fabs(oq.z))*2);}
  }
  for(int k=0;k<2;k++)heatT[k]*=E.x_cool;
  // ------------- sensors
  if(it%10==0)for(int c=0;c<18;c++)rw[c]=0;
  D dr[18];for(int c=0;c<18;c++){int k=c/6,cc=c%6;D u=k<2?(cc<3?S.uncF:S.uncT):(cc<3?S.uncFp:S.uncTp);rw[c]+=0.03*u*q.n();dr[c]=0.015*u*q.n();}
  FILE*f=fopen((dir+"/trials/"+id+".csv").c_str(),"w");static char big[1<<20];setvbuf(f,big,_IOFBF,sizeof big);
  fprintf(f,"t_s,grip_cmd_n,gripper_x_m,gripper_y_m,gripper_z_m,gripper_qw,gripper_qx,gripper_qy,gripper_qz,object_x_m,object_y_m,object_z_m,object_qw,object_qx,object_qy,object_qz");
  for(int k=0;k<3;k++)fprintf(f,",%s_fx_n,%s_fy_n,%s_fz_n,%s_tx_nm,%s_ty_nm,%s_tz_nm",sen[k],sen[k],sen[k],sen[k],sen[k],sen[k]);fprintf(f,"\n");
  auto at=[&](D tq,bool obj,D*o){D u=(tq-n0*h)/h;if(u<0)u=0;if(u>tr.size()-1.001)u=tr.size()-1.001;size_t i=(size_t)u;D fr=u-i;for(int c=0;c<7;c++){const D*pa=obj?tr[i].p:tr[i].g,*pb=obj?tr[i+1].p:tr[i+1].g;o[c]=pa[c]+fr*(pb[c]-pa[c]);}};
  D hy[4]={fo[0][0],fo[0][2],fo[0][6],fo[0][8]};
  for(size_t i=0;i<ts.size();i++){D tt=ts[i];D op[7],gp[7];at(clean?tt-E.lat:tt-S.latn-E.lat-E.x_skew*tt,true,op);at(tt,false,gp);
   array<D,18> o=fo[i];
   for(int k=0;k<3;k++){V F={o[6*k],o[6*k+1],o[6*k+2]},Mo={o[6*k+3],o[6*k+4],o[6*k+5]};
    if(E.x_hyst&&k<2){for(int c=0;c<2;c++){D&y=hy[2*k+c];D xx=c?F.z:F.x;if(xx>y+E.x_hyst)y=xx-E.x_hyst;if(xx<y-E.x_hyst)y=xx+E.x_hyst;(c?F.z:F.x)=y;}}
    V ro={E.mis[k][0],E.mis[k][1],E.mis[k][2]};if(ro.x||ro.y||ro.z){M B=qR(qe(ro));F=mul(B,F);Mo=mul(B,Mo);}
    D mainf=k<2?F.y:F.x;D c0=E.xt[k][0]+(clean?0:xn[k][0]),c1=E.xt[k][1]+(clean?0:xn[k][1]);
    if(k<2)F.x+=c0*mainf;else F.y+=c0*mainf;F.z+=c1*mainf;Mo.x+=E.xt[k][2]*mainf;Mo.y+=E.xt[k][3]*mainf;Mo.z+=E.xt[k][4]*mainf;
    D gg=1+E.gain[k]+(clean?0:gains[k]);F=gg*F;Mo=gg*Mo;
    D vv[6]={F.x,F.y,F.z,Mo.x,Mo.y,Mo.z};for(int c=0;c<6;c++){D z=vv[c]+E.bias[6*k+c];if(!clean){D nz=k<2?(c<3?S.noiseF:S.noiseT):(c<3?S.noiseFp:S.noiseTp);z+=biasS[6*k+c]+rw[6*k+c]+dr[6*k+c]*tt+nz*q.n();}o[6*k+c]=z;}}
   Q qo={op[3],op[4],op[5],op[6]};if(!clean){for(int c=0;c<3;c++){op[c]+=S.npos*q.n();gp[c]+=4e-6*q.n();}V e={S.nrot*q.n(),S.nrot*q.n(),S.nrot*q.n()};qo=qm(qe(e),qo);}qo=qn(qo);
   fprintf(f,"%.7g,%g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g",tt,t.grip,gp[0],gp[1],gp[2],gp[3],gp[4],gp[5],gp[6],op[0],op[1],op[2],qo.w,qo.x,qo.y,qo.z);
   for(int c=0;c<18;c++)fprintf(f,",%.6g",o[c]);fprintf(f,"\n");}
  fclose(f);
 }
 fclose(ft);
 FILE*k=fopen(keyf.c_str(),"w");fprintf(k,"{\"set\":%d,\"seed\":%llu,\"effects\":[",num,(unsigned long long)seed);for(size_t i=0;i<ef.size();i++)fprintf(k,"%s\"%s\"",i?",":"",ef[i].c_str());fprintf(k,"],\"strengths\":{");bool first=true;for(auto&s:strengths){fprintf(k,"%s\"%s\":%.6g",first?"":",",s.first.c_str(),s.second);first=false;}
 fprintf(k,"},\n\"drawn\":{\"pad_kn_n_m\":%.6g,\"pad_kt_n_m\":%.6g,\"mu_finger\":%.6g,\"mu_pusher\":%.6g,\"mass_kg\":%.6g,\"pad_diameter_true_m\":%.6g,\"friction_scatter\":%.4g,\"pusher_friction_scatter\":%.4g,\"creep_share\":%.4g,\"creep_s\":%.4g,\"wrist_n_m\":%.5g,\"wrist_nm_rad\":%.5g,\"jaw_series_n_m\":%.5g,\"pusher_contact_n_m\":%.5g,\"pusher_structure_n_m\":%.5g,\"loop_hz\":%.4g,\"loop_delay_s\":%.4g,\"stiction_share\":%.4g,\"mocap_latency_nuisance_s\":%.4g,\"sensor_filter_s\":%.4g,\"pad_tilt_rad\":[%.3g,%.3g,%.3g,%.3g],\"pusher_square_rad\":[%.3g,%.3g,%.3g],\"column_spread\":%.3g,\"rim_profile\":%.3g,\"load_reference_n\":25,",S.kn,S.kt,S.mu,S.mup,S.mass*(1+E.mfrac),2*ar,S.scat,S.scatp,S.phi,S.tauc,S.kw,S.krw,S.ks,S.kp,S.kstr,S.fl,S.delay,S.stic,S.latn,S.taus,pm[0].tx,pm[0].tz,pm[1].tx,pm[1].tz,psq[0],psq[1],psq[2],sgk,bk);
 fprintf(k,"\"mu_finger_by_trial\":[");for(size_t i=0;i<muT.size();i++)fprintf(k,"%s%.5g",i?",":"",muT[i]);
 fprintf(k,"],\"mu_finger1_by_trial\":[");for(size_t i=0;i<muT.size();i++)fprintf(k,"%s%.5g",i?",":"",mu1T[i]);fprintf(k,"],\"mu_finger2_by_trial\":[");for(size_t i=0;i<muT.size();i++)fprintf(k,"%s%.5g",i?",":"",mu2T[i]);
 fprintf(k,"],\"sensor_bias_nuisance\":[");for(int i=0;i<18;i++)fprintf(k,"%s%.4g",i?",":"",biasS[i]);
 fprintf(k,"]},\n\"numerics\":{\"step_s\":%.6g,\"columns_per_pad\":%d,\"min_pad_clearance_m\":%.5g,\"max_shift_z_m\":%.5g,\"max_roll_yaw_rad\":%.5g,\"dropped\":%d,\"trials\":%d,\"pad_damping_s\":%.4g}}\n",S.h,N,minclear,maxsag,maxrot,dropped,(int)muT.size(),S.taud);fclose(k);
 return 0;}
