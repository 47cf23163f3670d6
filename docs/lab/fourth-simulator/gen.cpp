// The simulator of docs/lab/fourth-simulator.md: evidence, not kept to the style of the repository.
//   g++ -std=c++17 -O3 -march=native -ffast-math -fno-math-errno -o gen gen.cpp && ./gen 401 882721 static_friction
// writes sets/401, its key keys/401.json and the friction told, told/401.toml, here; numbers, seeds and effects: plan.txt.
#include "phys.hpp"
#include <cstring>
#include <fstream>
#include <sstream>
#include <sys/stat.h>
#include <ctime>
#include <cstdlib>
using namespace std;
struct Rng{mt19937_64 g;explicit Rng(uint64_t s):g(s){} double u(){return (g()>>11)*(1.0/9007199254740992.0);} double u(double a,double b){return a+(b-a)*u();} double lu(double a,double b){return a*pow(b/a,u());}
 double n(){double a=u(),b=u();return sqrt(-2*log(a+1e-300))*cos(2*M_PI*b);} double sgn(){return u()<0.5?-1:1;} bool p(double q){return u()<q;}};
struct Obj{string id;double L,s,m,mTold;};
struct Cond{int kind,obj;double grip,speed,slope,off;};
struct KV{string k;double v;string unit,mean;};
struct Eff{string id,what,scope;bool listed=true;vector<KV> kv;};
static string num(double x){char b[40];snprintf(b,40,"%.7g",x);return b;}
static double rnd(double x,double q){return round(x/q)*q;}

int main(int argc,char**argv){
 if(argc<4){fprintf(stderr,"gen NNN seed effects|none [maxtrials]\n");return 1;}
 int id=atoi(argv[1]);uint64_t seed=strtoull(argv[2],0,10);vector<string> effs;{string s=argv[3],e;stringstream ss(s);while(getline(ss,e,','))if(e!="none")effs.push_back(e);}
 int maxT=argc>4?atoi(argv[4]):1000000; string root="./";for(const char*d:{"tmp","sets","keys","told"})mkdir(d,0755);
 auto has=[&](const char*e){return find(effs.begin(),effs.end(),e)!=effs.end();};
 Rng r(seed*7919+17); clock_t cpu0=clock();
 // ---------- nuisance
 double muF,muP,R,g0,K;vector<Obj> ob;int no;double massF=1; bool heavy=has("gravity_tilt")||has("mass_error");
 double f_told,p_told; vector<double> grips;
 if(has("mass_error")) massF=r.p(0.5)?r.u(1.2,1.5):r.u(0.55,0.82);
 for(;;){
  no=r.p(0.3)?2:1;ob.clear();muF=r.u(0.2,0.8);muP=r.u(0.2,0.65);
  R=0.5*rnd(r.u(0.014,0.022),0.001); double mg=0,smin=1;
  for(int i=0;i<no;i++){Obj o;o.L=rnd(r.u(0.08,0.15),0.005);o.s=rnd(r.u(0.022,0.045),0.001);double told=rnd(heavy?r.lu(0.25,1.0):r.lu(0.05,1.0),0.0005);o.m=told*(1+0.01*r.u(-1,1))*massF;o.mTold=told;o.id="obj"+to_string(i+1);ob.push_back(o);mg=max(mg,o.m*9.81);smin=min(smin,o.s);}
  g0=rnd(r.u(10,36),1);
  if(2*R>0.75*smin)continue; double hold=2*muF*g0*(1-0.0);
  if(mg>0.28*hold)continue; if(heavy&&ob[0].m*9.81<0.12*hold)continue; if(2*muF*g0*1.7>70)continue;
  if(no==2&&ob[0].L==ob[1].L&&ob[0].s==ob[1].s)continue;
  break;}
 double rr=r.u(1.25,1.4);grips={g0,rnd(g0*rr,1),min(60.0,rnd(g0*rr*rr*0.97,1))};
 K=r.lu(1e5,1.5e6); if(has("contact_compliance"))K=r.lu(1.0e4,3.0e4); if(has("face_tilt"))K=r.lu(1e5,2.2e5);
 double Kr=r.u(1.0,1.8),Kasy=r.u(-0.08,0.08);int nb=2*(int)r.u(15,41);nb=min(nb,80); double beta=r.p(0.35)?-1:r.u(0.3,0.9);
 double zeta=r.u(0.1,0.35),hard=r.p(0.3)?r.u(0,1):0; // hardening per (N/K)
 double sig=r.u(0.01,0.05),sigI=0.25*sig,sigP=r.u(0.01,0.04);
 double jM=r.u(0.05,0.4),jBW=r.u(6,40),jFc=r.p(0.5)?r.u(0.05,0.3):0; double gscat=r.u(0.001,0.004);
 double eKn=r.lu(1.5e6,6e6),eKt=eKn*r.u(0.6,0.9),eZ=r.u(0.15,0.35);
 double fn=r.lu(0.01,0.05),fu=rnd(r.u(0.1,0.3),0.05),tn=r.lu(0.0002,0.0008),tu=rnd(r.u(0.002,0.004),0.0005);
 double pn=r.lu(0.02,0.08),pu=rnd(r.u(0.3,0.8),0.05),ptn=r.lu(0.001,0.004),ptu=rnd(r.u(0.015,0.04),0.001);
 double xn=r.lu(1e-5,6e-5),qn=r.lu(1e-4,5e-4);
 double bias[18];for(int i=0;i<18;i++){double U=i<12?((i%6)<3?fu:tu):((i-12)<3?pu:ptu);bias[i]=0.6*U*r.u(-1,1);}
 V3 w0{rnd(r.u(-0.3,0.6),0.01),rnd(r.u(-0.3,0.3),0.01),rnd(r.u(0.05,0.4),0.01)}; double gripX=r.p(0.5)?rnd(r.u(-0.008,0.008),0.001):0;
 double v1=rnd(r.u(0.005,0.015),0.001),v2=rnd(r.u(0.02,0.05),0.001),w1=rnd(r.u(0.05,0.12),0.01),w2=rnd(r.u(0.25,0.42),0.01);
 double slA=rnd(r.u(8,24),1)*M_PI/180,slide=rnd(r.u(0.009,0.014),0.001),gap=rnd(r.u(0.0003,0.0009),0.0001); if(has("mocap_latency"))gap=rnd(r.u(0.001,0.0018),0.0001);
 double off2=rnd(r.u(0.008,0.018),0.001),eLen=0.028;
 bool blocked=r.p(0.5); double ta=r.u(0.02,0.05);
 f_told=muF*(1+0.15*r.u(-1,1));p_told=muP*(1+0.15*r.u(-1,1));
 V3 peOfs{2e-5*r.n(),2e-5*r.n(),2e-5*r.n()};double paS=r.lu(3e-5,2.5e-4),pa1=paS*r.n(),pa2=paS*r.n(); Q camQ=rotq({r.n(),r.n(),r.n()},3e-4*r.n());
 double mgv=0;for(auto&o:ob)mgv=max(mgv,o.m*9.81); double gm=grips[1];
 // ---------- hidden effects
 Phys H; vector<Eff> E; double mism=0,wear=0,wearTau=40,plTilt=0,plAx=0,gTilt=0,gDir=0,lat=0,sgain=0;int sgF=0;double xt[6][6]={};int xtF=0;double sb[18]={};double gGain=1,gOfs=0,tempTarget=0,adh=0,taper=0,jK=0; double heatK=0,heatTau=5;
 V3 armK{};double sprK=0,sprF=0;V3 sprD{};double magF=0,magD=1e-3,ripA=0,ripL=3e-3,ripTh=0,ssL=0,ssTh=0,ssF=30,ssZ=0.3,zenR=0,zenTau=0.3;
 for(auto&e:effs){ Eff x;x.id=e;
  if(e=="finger_friction_mismatch"){mism=r.sgn()*r.u(0.12,0.45);x.what="Coulomb friction differs between the two fingers: mu1 = mu(1+d/2), mu2 = mu(1-d/2)";x.kv={{"d",mism,"1","relative difference of mu, finger 1 minus finger 2"}};}
  else if(e=="pressure_offset"){double a=r.u(0,2*M_PI),d=r.u(0.15,0.42)*R;H.pOff={d*cos(a),0,d*sin(a)};x.what="centre of pressure on both pads away from the pad's centre (stiffness gradient of the pads, both at the same place so that a freely held object balances)";x.kv={{"offset_x",H.pOff.x,"m","along gripper X"},{"offset_z",H.pOff.z,"m","along gripper Z"}};}
  else if(e=="viscous_friction"){double t=r.u(0.12,0.5);H.visc=t*muF/v2;x.what="rate-dependent friction of the pads: mu + c v";x.kv={{"c",H.visc,"s/m","added friction coefficient per slip speed"},{"relative_at_fast_push",t,"1","share of mu added at the faster push speed"}};}
  else if(e=="static_friction"){H.stat=r.u(0.15,0.5);H.Dc=r.lu(3e-5,2e-4);double vs=r.lu(0.002,0.012);H.tauAge=H.Dc/vs;x.what="static friction of the pads above kinetic: mu(1+s theta), theta' = (1-theta)/tau - v theta/Dc (ages at rest, Stribeck when sliding)";x.kv={{"s",H.stat,"1","(mu_static-mu_kinetic)/mu_kinetic"},{"Dc",H.Dc,"m","slip over which it is lost"},{"tau",H.tauAge,"s","ageing time"},{"v_s",vs,"m/s","speed at which half remains"}};}
  else if(e=="load_dependent_friction"){H.loadE=r.p(0.7)?-r.u(0.15,0.5):r.u(0.15,0.3);H.N0=gm;x.what="friction of the pads depends on load: mu (N/N0)^e";x.kv={{"e",H.loadE,"1","exponent"},{"N0",gm,"N","reference load"}};}
  else if(e=="friction_wear"){wear=r.p(0.7)?-r.u(0.15,0.4):r.u(0.15,0.4);wearTau=r.u(25,90);x.what="friction of the pads drifts over the trials in the order of the list: mu(1+D(1-exp(-i/tau))/(1-exp(-59/tau)))";x.kv={{"D",wear,"1","relative change from first to last trial"},{"tau_trials",wearTau,"trials",""}};}
  else if(e=="face_tilt"){taper=r.u(0.10,0.25)*M_PI/180;double loss=r.u(0.15,0.4);double Kn=K*Kr;double ks=loss*gm/(tan(taper)*slide);ks=min(ks,0.8*Kn);jK=1/(1/ks-1/Kn);x.what="the object's sides taper (narrower towards -X) and the jaw holds with finite stiffness: grip lost as the object slides";double kse=1/(1/jK+1/Kn);x.kv={{"face_angle",taper,"rad","each side, about object Z"},{"jaw_stiffness",jK,"N/m","per finger"},{"loss_n_per_m",kse*tan(taper),"N/m","normal force lost per metre of slip, each finger"},{"loss_over_push",kse*tan(taper)*slide/gm,"1","share of the middle grip at the end of a push"}};}
  else if(e=="grip_force_lag"){H.lagA=r.u(0.15,0.45)/slide;H.lagTau=r.u(0.03,0.1);H.lagRec=r.u(1.5,5);x.what="grip force is lost while the pads slide and comes back slowly: L' = a v_slip(mean over the pad) - L/T, force F(1-L) behind a lag";x.kv={{"a",H.lagA,"1/m","share lost per metre of slip"},{"lag",H.lagTau,"s",""},{"recovery",H.lagRec,"s",""}};}
  else if(e=="plate_tilt"){plTilt=r.u(0.7,2.5)*M_PI/180;plAx=r.p(0.6)?M_PI/2*r.sgn():r.u(0,2*M_PI);x.what="the plate of the pushes is tilted against its told pose (the pivots' edge is not)";x.scope="pusher of linear_push";x.kv={{"tilt",plTilt,"rad",""},{"axis_y",cos(plAx-M_PI/2),"1","rotation axis, pusher Y part"},{"axis_z",-sin(plAx-M_PI/2),"1","rotation axis, pusher Z part"}};}
  else if(e=="sensor_gain"){sgain=r.sgn()*r.u(0.06,0.18);sgF=r.p(0.5);x.what="gain error of one finger's sensor, all six channels";x.scope=sgF?"finger 2":"finger 1";x.kv={{"gain_error",sgain,"1",""},{"finger",double(sgF+1),"",""}};}
  else if(e=="sensor_bias"){int f=r.p(0.5);double m=r.u(3,6);V3 d{r.n(),r.n(),r.n()};d=(1/norm(d))*d;V3 t{r.n(),r.n(),r.n()};t=(1/norm(t))*t;sb[6*f]=m*fu*d.x;sb[6*f+1]=m*fu*d.y;sb[6*f+2]=m*fu*d.z;sb[6*f+3]=m*tu*t.x;sb[6*f+4]=m*tu*t.y;sb[6*f+5]=m*tu*t.z;x.what="constant error of one finger's sensor beyond its stated bound";x.scope=f?"finger 2":"finger 1";const char*c[]={"fx","fy","fz","tx","ty","tz"};for(int i=0;i<6;i++)x.kv.push_back({c[i],sb[6*f+i],i<3?"N":"Nm","added, gripper axes"});x.kv.push_back({"times_bound",m,"1","length of the force (torque) error over the stated bound"});x.kv.push_back({"finger",double(f+1),"",""});}
  else if(e=="sensor_crosstalk"){xtF=r.p(0.5);x.what="crosstalk of one finger's sensor: normal force leaks into shear and torque";x.scope=xtF?"finger 2":"finger 1";double a=r.sgn()*r.u(0.03,0.09),b=r.sgn()*r.u(0.02,0.08),c=r.sgn()*r.u(0.0002,0.001);xt[0][1]=a;xt[2][1]=b;xt[4][1]=c;x.kv={{"fx_from_fy",a,"1",""},{"fz_from_fy",b,"1",""},{"ty_from_fy",c,"m",""},{"finger",double(xtF+1),"",""}};}
  else if(e=="gravity_tilt"){gTilt=r.u(3,8)*M_PI/180;gDir=r.u(0,2*M_PI);x.what="gravity is not along world -Z";x.kv={{"tilt",gTilt,"rad",""},{"dir_x",cos(gDir),"1","world X part of the added horizontal pull"},{"dir_y",sin(gDir),"1",""}};}
  else if(e=="mass_error"){x.what="true mass against told";x.kv={{"relative_error",massF-1,"1","true over told, less one (all objects), before the ordinary 1 %"}};}
  else if(e=="friction_anisotropy"){H.aniso=r.sgn()*r.u(0.25,0.7);x.what="friction of the pads anisotropic in gripper axes: mu_x = mu(1+a/2), mu_z = mu(1-a/2), ellipse, slip by maximal dissipation";x.kv={{"a",H.aniso,"1",""}};}
  else if(e=="adhesion"){adh=r.u(0.15,0.45)*gm;x.what="pads adhere: limit mu(N+A), A spread over the pad";x.kv={{"A",adh,"N","per finger"}};}
  else if(e=="contact_compliance"){x.what="soft pads";x.kv={{"shear_stiffness",K,"N/m","per finger"},{"normal_stiffness",K*Kr,"N/m","per finger"}};}
  else if(e=="mocap_latency"){lat=r.u(0.04,0.13);x.what="the object's pose is late against forces and gripper";x.kv={{"latency",lat,"s",""}};}
  else if(e=="grip_force_error"){gGain=1+r.sgn()*r.u(0.08,0.22);gOfs=r.u(-1,1)*0.05*g0;x.what="grip force is not as commanded: N = gain*cmd + offset (the measured normal force shows it)";x.kv={{"gain",gGain,"1",""},{"offset",gOfs,"N",""}};}
  else if(e=="u_spring"){x.listed=false;sprK=r.lu(100,500);sprF=r.u(0.1,0.3)*2*muF*g0*0.6;sprD={r.u(-0.4,0.4),r.u(-0.2,0.2),r.sgn()};sprD=(1/norm(sprD))*sprD;x.what="a spring (cable) pulls at the object's +X end, not through any sensor";x.kv={{"stiffness",sprK,"N/m","isotropic, zero extension at the start besides the preload"},{"preload",sprF,"N","at the start"},{"dir_x",sprD.x,"1","world direction of the preload on the object"},{"dir_y",sprD.y,"1",""},{"dir_z",sprD.z,"1",""}};}
  else if(e=="u_magnet"){x.listed=false;magF=r.u(0.12,0.35)*2*muF*g0;magD=r.u(5e-4,2e-3);x.what="a magnet behind the plate pulls the object's face towards the plate (pushes only): F0/(1+gap/d)^2, not through the sensor";x.scope="linear_push";x.kv={{"F0",magF,"N",""},{"d",magD,"m",""}};}
  else if(e=="u_arm_bends"){x.listed=false;double k=r.lu(4e3,2e4);armK={k*r.u(0.8,1.6),k*r.u(1.5,3),k*r.u(0.5,1)};x.what="the gripper's arm bends under load; the reported gripper pose is the encoders'";x.kv={{"kx",armK.x,"N/m",""},{"ky",armK.y,"N/m",""},{"kz",armK.z,"N/m",""},{"mass",2,"kg","moving mass"}};}
  else if(e=="u_drive_ripple"){x.listed=false;ripL=r.u(0.002,0.005);ripA=r.u(0.25,0.6)*ripL/(2*M_PI);ripTh=r.u(0.2,0.6)*0.06/(2*M_PI);x.what="the drive wobbles across its path with a fixed pitch (pushes: in the XZ plane across the push; pivots: speed ripple and vertical wobble, period 0.06 rad); not in the reported pose";x.kv={{"amplitude",ripA,"m",""},{"pitch",ripL,"m",""},{"pivot_amplitude",ripTh,"rad",""}};}
  else if(e=="u_drive_stickslip"){x.listed=false;ssF=r.u(40,60);ssL=v1/(r.u(0.15,0.35)*ssF);ssTh=w1/(r.u(0.15,0.35)*ssF);ssZ=r.u(0.55,0.7);x.what="the drive moves in jerks (steps of the size given) and rings, so that the slip reverses; the reported pose is the smooth command; slow speeds only (smooth above 0.4 steps per ring period)";x.kv={{"step",ssL,"m","pushes"},{"step_angle",ssTh,"rad","pivots"},{"ring_frequency",ssF,"Hz",""},{"ring_damping",ssZ,"1",""}};}
  else if(e=="u_temperature"){x.listed=false;tempTarget=r.sgn()>0?r.u(0.2,0.5):-r.u(0.2,0.4);heatTau=r.u(2,8);heatK=tempTarget/(2*muF*gm*slide);x.what="friction of the pads changes with the heat of sliding within a trial: mu(1+k E), E' = P - E/tau, E = 0 at the start of each";x.kv={{"k",heatK,"1/J",""},{"tau",heatTau,"s",""},{"change_over_push",tempTarget,"1","at the end of a middle push, without cooling"}};}
  else if(e=="u_zener"){x.listed=false;zenR=r.u(0.4,0.75);zenTau=r.u(0.1,0.8);K=r.lu(1.5e4,6e4);x.what="pads relax in shear (Zener): force k(z - rho q), q' = (z-q)/tau, on pads of the stiffness given";x.kv={{"rho",zenR,"1","share that relaxes"},{"tau",zenTau,"s",""},{"shear_stiffness",K,"N/m","instantaneous, per finger"}};}
  else {fprintf(stderr,"unknown effect %s\n",e.c_str());return 1;}
  E.push_back(x);}
 if(has("friction_wear"))blocked=true;
 bool twin=getenv("TWIN"); // the same set with nothing hidden, for the size of the effect only
 if(twin){H=Phys();mism=wear=plTilt=gTilt=lat=sgain=adh=taper=jK=heatK=sprK=magF=ripA=ripTh=ssL=ssTh=zenR=0;gGain=1;gOfs=0;armK={};for(auto&a:xt)for(double&b:a)b=0;for(double&b:sb)b=0;for(auto&o:ob)o.m/=massF;if(K<9e4)K=4e5;}
 // ---------- conditions
 vector<Cond> C; double sl[3]={-slA,0,slA};
 if(no==1){ for(double g:grips)for(double v:{v1,v2})for(double q:sl)C.push_back({0,0,g,v,q,0}); for(double g:grips)for(double w:{w1,w2})for(double o:{0.0,off2})C.push_back({1,0,g,w,0,o}); }
 else { for(int o=0;o<2;o++)for(int i=0;i<3;i++)for(int j=0;j<3;j++)C.push_back({0,o,grips[i],(i+j+o)%2?v2:v1,sl[j],0}); for(int o=0;o<2;o++)for(int i=0;i<3;i++)for(int j=0;j<2;j++)C.push_back({1,o,grips[i],(i+j+o)%2?w2:w1,0,j?off2:0}); }
 vector<pair<int,int>> order; if(blocked){for(int q=0;q<2;q++)for(size_t i=0;i<C.size();i++)order.push_back({(int)i,q});}else for(size_t i=0;i<C.size();i++)for(int q=0;q<2;q++)order.push_back({(int)i,q});
 // ---------- files
 char nn[16];snprintf(nn,16,"%03d",id);string tmp=root+"tmp/"+nn+(twin?"t":"");system(("rm -rf "+tmp).c_str());mkdir(tmp.c_str(),0755);mkdir((tmp+"/trials").c_str(),0755);
 {ofstream f(tmp+"/dataset.toml");f<<"format = \"stickslip-dataset/1\"\nname = \"bench4-"<<nn<<"\"\nsample_rate_hz = 250.0\ngravity_m_s2 = [0.0, 0.0, -9.81]\n";
  for(auto&o:ob)f<<"\n[[objects]]\nid = \""<<o.id<<"\"\nshape = \"prism\"\nlength_m = "<<num(o.L)<<"\nside_m = "<<num(o.s)<<"\nmass_kg = "<<num(o.mTold)<<"\n";
  f<<"\n[fingers]\ncontact = \"disc\"\ndiameter_m = "<<num(2*R)<<"\n\n[pushers.linear_push]\ncontact = \"plane\"\n\n[pushers.pivot]\ncontact = \"line\"\nlength_m = "<<num(eLen)<<"\n\n";
  f<<"[sensors.finger]\nforce_noise_n = "<<num(fn)<<"\nforce_uncertainty_n = "<<num(fu)<<"\ntorque_noise_nm = "<<num(tn)<<"\ntorque_uncertainty_nm = "<<num(tu)<<"\n\n[sensors.pusher]\nforce_noise_n = "<<num(pn)<<"\nforce_uncertainty_n = "<<num(pu)<<"\ntorque_noise_nm = "<<num(ptn)<<"\ntorque_uncertainty_nm = "<<num(ptu)<<"\n\n[sensors.pose]\nposition_noise_m = "<<num(xn)<<"\nrotation_noise_rad = "<<num(qn)<<"\n";}
 ofstream tr(tmp+"/trials.csv");tr<<"trial,file,object,primitive,grip_n,speed_m_s,speed_rad_s,slope_rad,pusher_offset_m,run,pusher_x_m,pusher_y_m,pusher_z_m,pusher_qw,pusher_qx,pusher_qy,pusher_qz\n";
 string keyT; double dtUsed=0;
 for(size_t ti=0;ti<order.size()&&(int)ti<maxT;ti++){ Cond c=C[order[ti].first];int run=order[ti].second;Obj&o=ob[c.obj];
  Phys P=H; P.m=o.m;P.L=o.L;P.s=o.s;P.taper=taper;P.R=R;P.nb=nb;P.Kt[0]=K*(1+Kasy);P.Kt[1]=K*(1-Kasy);P.Kn[0]=K*Kr*(1+Kasy);P.Kn[1]=K*Kr*(1-Kasy);P.zeta=zeta;P.zetaN=zeta;P.hard=hard*K*Kr/gm;P.beta=beta;
  double fw=1; if(wear!=0)fw=1+wear*(1-exp(-double(ti)/wearTau))/(1-exp(-59/wearTau));
  double rc=1+sig*r.n(),r1=1+sigI*r.n(),r2=1+sigI*r.n(),rp=1+sigP*r.n();
  P.mu[0]=muF*(1+mism/2)*fw*rc*r1;P.mu[1]=muF*(1-mism/2)*fw*rc*r2;P.eMu=muP*rp;
  P.adh=adh;P.heatK=heatK;P.heatTau=heatTau;P.zenR=zenR;P.zenTau=zenTau;
  P.grip=c.grip;P.gripGain=gGain*(1+gscat*r.n());P.gripOfs=gOfs;P.jawM=jM;P.jawBW=jBW;P.jawC=2*0.7*sqrt(2*K*Kr*2*jM)*0.3;P.jawFc=jFc;P.jawK=jK;
  P.eKn=eKn;P.eKt=eKt;P.eZ=eZ;P.eLen=eLen;P.g0=w0;P.gripX=gripX;P.kind=c.kind;P.ta=ta;P.speed=c.speed;P.slope=c.slope;
  P.rest=0.4;P.tail=0.25;P.settle=armK.x>0?0.5:0.25; if(K<4e4)P.settle=0.4;
  P.g={9.81*sin(gTilt)*cos(gDir),9.81*sin(gTilt)*sin(gDir),-9.81*cos(gTilt)};
  P.armK=armK;P.ripA=ripA;P.ripL=ripL;P.ripTh=ripTh;P.ripPh=0;P.ssL=ssL;P.ssTh=ssTh;P.ssF=ssF;P.ssZ=ssZ;P.magF=magF;P.magD=magD;
  V3 oc=w0-V3{gripX,0,0}; V3 tp;Q tq; // told pusher pose
  if(c.kind==0){tp=oc+V3{-o.L/2-gap,0,0};tq={};P.env=0;P.len=slide+gap/cos(c.slope);P.eq=rotq({0,cos(plAx-M_PI/2),-sin(plAx-M_PI/2)},plTilt)*rotq({0,1,0},pa1)*rotq({0,0,1},pa2);}
  else {tp=oc+V3{-0.45*o.L+c.off,0,-o.s/2-gap};tq=rotq({0,1,0},-M_PI/2);P.env=1;P.len=min(c.speed*2.0,0.75);P.eq=tq*rotq({1,0,0},pa1);}
  P.ep=tp+peOfs;
  if(sprK>0){P.sprB={o.L/2,0,0};P.sprA=oc+P.sprB;P.sprK={sprK,sprK,sprK};P.sprF=sprF*sprD;}
  double wm=sqrt((2*P.Kn[0]*(1+0.5*hard)+eKn)/P.m*(1+3*0.25*P.L*P.L/(P.L*P.L+P.s*P.s)*1.0+1.5)); P.dt=wm*40e-6<0.6?40e-6:wm*20e-6<0.6?20e-6:10e-6; dtUsed=P.dt;
  Sim S(P);S.run(); if(S.rows.empty()){fprintf(stderr,"set %d trial %zu failed\n",id,ti);return 2;}
  char tn_[16];snprintf(tn_,16,"t%04zu",ti);
  tr<<tn_<<",trials/"<<tn_<<".csv,"<<o.id<<","<<(c.kind?"pivot":"linear_push")<<","<<num(c.grip)<<","<<(c.kind?"":num(c.speed))<<","<<(c.kind?num(c.speed):"")<<","<<(c.kind?"":num(c.slope))<<","<<(c.kind?num(c.off):"")<<","<<run<<","<<num(tp.x)<<","<<num(tp.y)<<","<<num(tp.z)<<","; char qb[120];snprintf(qb,120,"%.9g,%.9g,%.9g,%.9g\n",tq.w,tq.x,tq.y,tq.z);tr<<qb;
  FILE*f=fopen((tmp+"/trials/"+tn_+".csv").c_str(),"w");
  fputs("t_s,grip_cmd_n,gripper_x_m,gripper_y_m,gripper_z_m,gripper_qw,gripper_qx,gripper_qy,gripper_qz,object_x_m,object_y_m,object_z_m,object_qw,object_qx,object_qy,object_qz,finger1_fx_n,finger1_fy_n,finger1_fz_n,finger1_tx_nm,finger1_ty_nm,finger1_tz_nm,finger2_fx_n,finger2_fy_n,finger2_fz_n,finger2_tx_nm,finger2_ty_nm,finger2_tz_nm,pusher_fx_n,pusher_fy_n,pusher_fz_n,pusher_tx_nm,pusher_ty_nm,pusher_tz_nm\n",f);
  double dr[18],ph[18];for(int i=0;i<18;i++){double U=i<12?((i%6)<3?fu:tu):((i-12)<3?pu:ptu);dr[i]=0.1*U*r.u(-1,1);ph[i]=0.05*U*r.u(-1,1);}
  double T=S.rows.back().t;
  for(size_t k=0;k<S.rows.size();k++){Row&a=S.rows[k];
   // object's pose, late if asked
   V3 op=a.op;Q oq=a.oq; if(lat>0){double tt=a.t-lat;if(tt<=0){op=S.rows[0].op;oq=S.rows[0].oq;}else{size_t j=min((size_t)(tt/0.004),S.rows.size()-2);double q=(tt-S.rows[j].t)/0.004;Row&b=S.rows[j],&d=S.rows[j+1];op=(1-q)*b.op+q*d.op;oq=unit({(1-q)*b.oq.w+q*d.oq.w,(1-q)*b.oq.x+q*d.oq.x,(1-q)*b.oq.y+q*d.oq.y,(1-q)*b.oq.z+q*d.oq.z});}}
   op+=V3{xn*r.n(),xn*r.n(),xn*r.n()}; V3 rv{qn*r.n(),qn*r.n(),qn*r.n()}; oq=unit(oq*camQ*rotq(rv,norm(rv))); if(oq.w<0)oq={-oq.w,-oq.x,-oq.y,-oq.z};
   double s[18]={a.f[0].x,a.f[0].y,a.f[0].z,a.tq[0].x,a.tq[0].y,a.tq[0].z,a.f[1].x,a.f[1].y,a.f[1].z,a.tq[1].x,a.tq[1].y,a.tq[1].z};
   V3 pt=a.pt+cross(P.ep-tp,a.pf); s[12]=a.pf.x;s[13]=a.pf.y;s[14]=a.pf.z;s[15]=pt.x;s[16]=pt.y;s[17]=pt.z;
   double m[18];for(int i=0;i<18;i++)m[i]=s[i];
   for(int i=0;i<6;i++)for(int j=0;j<6;j++)m[6*xtF+i]+=xt[i][j]*s[6*xtF+j];
   if(sgain!=0)for(int i=0;i<6;i++)m[6*sgF+i]*=1+sgain;
   for(int i=0;i<18;i++){double n=i<12?((i%6)<3?fn:tn):((i-12)<3?pn:ptn);m[i]+=bias[i]+sb[i]+ph[i]+dr[i]*a.t/T+n*r.n();}
   fprintf(f,"%.7g,%.7g,%.8g,%.8g,%.8g,%.9g,%.9g,%.9g,%.9g,%.7g,%.7g,%.7g,%.9g,%.7g,%.7g,%.7g",a.t,c.grip,a.gp.x,a.gp.y,a.gp.z,a.gq.w,a.gq.x,a.gq.y,a.gq.z,op.x,op.y,op.z,oq.w,oq.x,oq.y,oq.z);
   for(int i=0;i<18;i++)fprintf(f,",%.6g",m[i]); fputc('\n',f);}
  fclose(f);
  char kb[400];Row&z=S.rows.back();Row&y=S.rows[0];snprintf(kb,400,"%s    {\"trial\": \"%s\", \"mu_finger1\": %.5f, \"mu_finger2\": %.5f, \"mu_pusher\": %.5f, \"object_moved_m\": [%.6f, %.6f, %.6f], \"normal_start_n\": %.3f, \"normal_end_n\": %.3f}",ti?",\n":"",tn_,P.mu[0],P.mu[1],P.eMu,z.op.x-y.op.x,z.op.y-y.op.y,z.op.z-y.op.z,y.f[1].y,z.f[1].y);keyT+=kb;
 }
 tr.close();
 // ---------- key
 if(!twin){ofstream f(root+"keys/"+nn+".json");auto N=[&](const char*k,double v,bool c=true){f<<"    \""<<k<<"\": "<<num(v)<<(c?",\n":"\n");};
  f<<"{\n  \"set\": \""<<nn<<"\",\n  \"seed\": "<<seed<<",\n  \"effects\": [";for(size_t i=0;i<E.size();i++)f<<(i?", ":"")<<"\""<<E[i].id<<"\"";f<<"],\n  \"detail\": [";
  for(size_t i=0;i<E.size();i++){f<<(i?",":"")<<"\n    {\"id\": \""<<E[i].id<<"\", \"listed\": "<<(E[i].listed?"true":"false")<<", \"what\": \""<<E[i].what<<"\""<<(E[i].scope.empty()?"":", \"scope\": \""+E[i].scope+"\"")<<", \"strength\": {";for(size_t j=0;j<E[i].kv.size();j++){auto&k=E[i].kv[j];f<<(j?", ":"")<<"\""<<k.k<<"\": {\"value\": "<<num(k.v)<<", \"unit\": \""<<k.unit<<"\""<<(k.mean.empty()?"":", \"meaning\": \""+k.mean+"\"")<<"}";}f<<"}}";}
  f<<"\n  ],\n  \"true\": {\n";N("mu_finger",muF);N("mu_pusher",muP);N("pad_shear_stiffness_finger1_n_m",K*(1+Kasy));N("pad_shear_stiffness_finger2_n_m",K*(1-Kasy));N("pad_normal_stiffness_finger1_n_m",K*Kr*(1+Kasy));N("pad_normal_stiffness_finger2_n_m",K*Kr*(1-Kasy));N("pad_normal_hardening",hard);N("pad_damping_ratio",zeta);N("bristles_per_pad",2*(nb/2));N("elastoplastic_beta_(-1:LuGre)",beta);
  N("run_sigma_finger_common",sig);N("run_sigma_finger_each",sigI);N("run_sigma_pusher",sigP);N("run_sigma_grip",gscat);N("jaw_mass_kg_each",jM);N("jaw_bandwidth_hz",jBW);N("jaw_dry_friction_n",jFc);N("env_normal_stiffness_n_m",eKn);N("env_shear_stiffness_n_m",eKt);N("grip_point_x_on_object_m",gripX);N("pusher_position_error_x_m",peOfs.x);N("pusher_position_error_y_m",peOfs.y);N("pusher_position_error_z_m",peOfs.z);N("pusher_angle_error_1_rad",pa1);N("pusher_angle_error_2_rad",pa2);N("dt_s",dtUsed);
  f<<"    \"mass_kg\": [";for(size_t i=0;i<ob.size();i++)f<<(i?", ":"")<<num(ob[i].m);f<<"],\n    \"sensor_bias_within_bounds\": [";for(int i=0;i<18;i++)f<<(i?", ":"")<<num(bias[i]);f<<"]\n  },\n  \"told\": {\n";N("mu_finger",f_told);N("mu_pusher",p_told);f<<"    \"mass_kg\": [";for(size_t i=0;i<ob.size();i++)f<<(i?", ":"")<<num(ob[i].mTold);f<<"]\n  },\n  \"trial_order\": \""<<(blocked?"all conditions run 0, then all run 1":"runs of a condition side by side")<<"\",\n  \"trials\": [\n"<<keyT<<"\n  ]\n}\n";}
 if(!twin){ofstream f(root+"told/"+nn+".toml");f<<"format = \"stickslip-model/1\"\nbase = \"hard\"\n\n[friction]\nfinger = "<<num(rnd(f_told,1e-4))<<"\npusher = "<<num(rnd(p_told,1e-4))<<"\n";}
 if(maxT>=60&&!twin){string dst=root+"sets/"+nn;system(("rm -rf "+dst).c_str());rename(tmp.c_str(),dst.c_str());}
 printf("%s %s cpu %.1f s; m",nn,argv[3],double(clock()-cpu0)/CLOCKS_PER_SEC);for(auto&o:ob)printf(" %.3f",o.m);printf(" mu %.3f %.3f g %g %g %g K %.3g nb %d beta %.2f dt %.0fus R %.4f slide %.4f v %g %g\n",muF,muP,grips[0],grips[1],grips[2],K,nb,beta,dtUsed*1e6,R,slide,v1,v2);
}
