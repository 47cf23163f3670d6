// sim10: gripper, prism and pusher as compliant bodies in fine semi-implicit steps (see README.md).
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <map>
#include <random>
#include <string>
#include <vector>
#include <array>
#include <algorithm>
#include <sys/stat.h>
using namespace std;
typedef double D;
struct V{D x,y,z;};
static inline V operator+(V a,V b){return{a.x+b.x,a.y+b.y,a.z+b.z};}
static inline V operator-(V a,V b){return{a.x-b.x,a.y-b.y,a.z-b.z};}
static inline V operator*(D s,V a){return{s*a.x,s*a.y,s*a.z};}
static inline D dot(V a,V b){return a.x*b.x+a.y*b.y+a.z*b.z;}
static inline V cross(V a,V b){return{a.y*b.z-a.z*b.y,a.z*b.x-a.x*b.z,a.x*b.y-a.y*b.x};}
static inline D len(V a){return sqrt(dot(a,a));}
struct M{V a,b,c;}; // columns
static inline V mul(const M&m,V v){return v.x*m.a+v.y*m.b+v.z*m.c;}
static inline V tmul(const M&m,V v){return{dot(m.a,v),dot(m.b,v),dot(m.c,v)};}
static inline M mm(const M&p,const M&q){return{mul(p,q.a),mul(p,q.b),mul(p,q.c)};}
static inline M tmm(const M&p,const M&q){return{tmul(p,q.a),tmul(p,q.b),tmul(p,q.c)};}
struct Q{D w,x,y,z;};
static Q qmul(Q a,Q b){return{a.w*b.w-a.x*b.x-a.y*b.y-a.z*b.z,a.w*b.x+a.x*b.w+a.y*b.z-a.z*b.y,a.w*b.y-a.x*b.z+a.y*b.w+a.z*b.x,a.w*b.z+a.x*b.y-a.y*b.x+a.z*b.w};}
static Q qn(Q q){D n=1/sqrt(q.w*q.w+q.x*q.x+q.y*q.y+q.z*q.z);return{q.w*n,q.x*n,q.y*n,q.z*n};}
static M qm(Q q){D w=q.w,x=q.x,y=q.y,z=q.z;return{{1-2*(y*y+z*z),2*(x*y+w*z),2*(x*z-w*y)},{2*(x*y-w*z),1-2*(x*x+z*z),2*(y*z+w*x)},{2*(x*z+w*y),2*(y*z-w*x),1-2*(x*x+y*y)}};}
static Q qv(V r){D a=len(r);if(a<1e-14)return{1,r.x/2,r.y/2,r.z/2};D s=sin(a/2)/a;return{cos(a/2),s*r.x,s*r.y,s*r.z};}

struct Rng{mt19937_64 g;Rng(uint64_t s):g(s){for(int i=0;i<20;i++)g();}
 D u(){return(g()>>11)*(1.0/9007199254740992.0);} D u(D a,D b){return a+(b-a)*u();}
 D lu(D a,D b){return exp(u(log(a),log(b)));} D n(){D a=u()+1e-17,b=u();return sqrt(-2*log(a))*cos(2*M_PI*b);}
 D nc(D s,D c){return max(-c,min(c,s*n()));} int i(int k){return(int)(u()*k);} D sg(){return u()<.5?-1:1;}
 template<class T>void sh(vector<T>&v){for(int k=v.size()-1;k>0;k--)swap(v[k],v[i(k+1)]);}};

const int NM=32;
struct Lin{D c,x,z;};
struct Con{int n=0;alignas(64) D x[NM],z[NM],kn[NM],kt[NM],z1[NM],z2[NM],m[NM],mb[NM],ad[NM],age[NM];alignas(64) D g1[3][NM],g2[3][NM];
 void clear(){memset(z1,0,sizeof z1);memset(z2,0,sizeof z2);memset(g1,0,sizeof g1);memset(g2,0,sizeof g2);}};
struct Fr{D mu1,mu2,bn,bt;int kind;D excess=0,vs=.002,visc=0,strength=0,cut=.05,ren=2e-5;};
struct Sum{D N=0,f1=0,f2=0,xN=0,zN=0,x1=0,z1=0,x2=0,z2=0;};

static Sum step_contact(Con&k,Lin d,Lin dd,Lin v1,Lin v2,const Fr&p,D dt){
 const int n=k.n;alignas(64) D N[NM],a1[NM],a2[NM],F1[NM],F2[NM],w[NM];
 for(int i=0;i<n;i++){D x=k.x[i],z=k.z[i];D de=d.c+d.x*x+d.z*z,dv=dd.c+dd.x*x+dd.z*z;D f=k.kn[i]*(de+p.bn*dv);
  N[i]=de>0&&f>0?f:0;a1[i]=v1.c+v1.x*x+v1.z*z;a2[i]=v2.c+v2.x*x+v2.z*z;w[i]=k.mb[i];}
 if(p.excess!=0)for(int i=0;i<n;i++){D v=sqrt(a1[i]*a1[i]+a2[i]*a2[i]);w[i]*=1+p.excess*exp(-v/p.vs);}
 if(p.visc!=0){D mu=sqrt(p.mu1*p.mu2);for(int i=0;i<n;i++){D v=sqrt(a1[i]*a1[i]+a2[i]*a2[i]);w[i]*=1+p.visc*v/mu;}}
 if(p.strength!=0)for(int i=0;i<n;i++)w[i]*=1+p.strength*log(1+k.age[i]/p.cut);
 const D i1=1/(p.mu1*p.mu1),i2=1/(p.mu2*p.mu2),q1=p.mu1*p.mu1,q2=p.mu2*p.mu2,mm_=max(p.mu1,p.mu2),idt=1/dt;
 if(p.kind<2){const bool ep=p.kind==1;
  for(int i=0;i<n;i++){D L=N[i]>0?N[i]+k.ad[i]:0,K=k.kt[i],iw=1/w[i];
   D s=sqrt(q1*a1[i]*a1[i]+q2*a2[i]*a2[i]);D c=s*K*iw*dt/(L+1e-9);
   D t1=k.z1[i]+a1[i]*dt,t2=k.z2[i]+a2[i]*dt;
   D al=1;
   if(ep){D r=K*iw*sqrt(i1*t1*t1+i2*t2*t2)/(L+1e-9);D e=(r-.65)/.35;e=e<0?0:e>1?1:e;al=e*e*(3-2*e);al=(t1*a1[i]+t2*a2[i])>0?al:0;}
   D b1=t1/(1+al*c*i1),b2=t2/(1+al*c*i2);
   D r=K*iw*sqrt(i1*b1*b1+i2*b2*b2);D sc=r>L?L/r:1;b1*=sc;b2*=sc;
   D lim=.5*mm_*w[i]*L,e1=p.bt*K*(b1-k.z1[i])*idt,e2=p.bt*K*(b2-k.z2[i])*idt;
   e1=e1>lim?lim:e1<-lim?-lim:e1;e2=e2>lim?lim:e2<-lim?-lim:e2;
   k.z1[i]=b1;k.z2[i]=b2;F1[i]=K*b1+e1;F2[i]=K*b2+e2;}
 }else{ // Iwan: three Jenkins elements of equal stiffness and unequal yield
  const D ph[3]={.14,.30,.56};
  for(int i=0;i<n;i++)F1[i]=F2[i]=0;
  for(int j=0;j<3;j++)for(int i=0;i<n;i++){D L=N[i]>0?N[i]+k.ad[i]:0;D kk=k.kt[i]/3;
   D t1=k.g1[j][i]+kk*a1[i]*dt,t2=k.g2[j][i]+kk*a2[i]*dt;D r=sqrt(i1*t1*t1+i2*t2*t2),y=ph[j]*w[i]*L;D sc=r>y?y/r:1;
   t1*=sc;t2*=sc;k.g1[j][i]=t1;k.g2[j][i]=t2;F1[i]+=t1;F2[i]+=t2;}
  for(int i=0;i<n;i++){D L=N[i]>0?N[i]+k.ad[i]:0;D b1=F1[i]/k.kt[i],b2=F2[i]/k.kt[i];
   D lim=.5*mm_*w[i]*L,e1=p.bt*k.kt[i]*(b1-k.z1[i])*idt,e2=p.bt*k.kt[i]*(b2-k.z2[i])*idt;
   e1=e1>lim?lim:e1<-lim?-lim:e1;e2=e2>lim?lim:e2<-lim?-lim:e2;
   D o1=k.z1[i],o2=k.z2[i];(void)o1;(void)o2;k.z1[i]=b1;k.z2[i]=b2;F1[i]+=e1;F2[i]+=e2;}
 }
 if(p.strength!=0)for(int i=0;i<n;i++){D v=sqrt(a1[i]*a1[i]+a2[i]*a2[i]);
   // only what slides renews: the share of the bristle's limit that is used, to the fourth
   D L=N[i]+k.ad[i]+1e-9;D r=k.kt[i]*sqrt(i1*k.z1[i]*k.z1[i]+i2*k.z2[i]*k.z2[i])/(w[i]*L);r=r>1?1:r;r*=r;r*=r;
   k.age[i]=(k.age[i]+dt)/(1+r*v*dt/p.ren);}
 Sum S;for(int i=0;i<n;i++){D x=k.x[i],z=k.z[i];S.N+=N[i];S.f1+=F1[i];S.f2+=F2[i];S.xN+=x*N[i];S.zN+=z*N[i];S.x1+=x*F1[i];S.z1+=z*F1[i];S.x2+=x*F2[i];S.z2+=z*F2[i];}
 return S;}

struct Eff{string id;vector<pair<string,D>>p;};
static vector<Eff> effs;
static bool has(const string&id){for(auto&e:effs)if(e.id==id)return true;return false;}
static D P(const char*id,const char*k,D def=0){for(auto&e:effs)if(e.id==id)for(auto&q:e.p)if(q.first==k)return q.second;return def;}
static const char*unitof(const string&k){
 if(k.size()>4&&k.substr(k.size()-4)=="_rad")return"rad";
 if(k.size()>4&&k.substr(k.size()-4)=="_1_m")return"1/m";
 if(k.size()>4&&k.substr(k.size()-4)=="_n_m")return"N/m";
 if(k.size()>4&&k.substr(k.size()-4)=="_s_m")return"s/m";
 if(k.size()>4&&k.substr(k.size()-4)=="_m_s")return"m/s";
 if(k.size()>3&&k.substr(k.size()-3)=="_nm")return"N m";
 if(k.size()>3&&k.substr(k.size()-3)=="_hz")return"Hz";
 if(k=="stiffness_n_m")return"N/m";
 if(k.size()>2&&k.substr(k.size()-2)=="_m")return"m";
 if(k.size()>2&&k.substr(k.size()-2)=="_n")return"N";
 if(k.size()>2&&k.substr(k.size()-2)=="_s")return"s";
 return"1";}

static Eff draw(const string&id,Rng&r,D side){
 Eff e;e.id=id;D k=r.lu(1,4);auto a=[&](const char*n,D v){e.p.push_back({n,v});};
 if(id=="static_friction"){a("excess",.2*k);a("stribeck_speed_m_s",r.lu(.001,.004));a("elsewhere",0);}
 else if(id=="viscous_friction"){a("viscosity_s_m",2*k);a("elsewhere",0);}
 else if(id=="dwell_strengthening"){a("strengthening",.05*k);a("cutoff_s",r.lu(.03,.1));a("renewal_m",r.lu(1e-5,5e-5));a("elsewhere",0);}
 else if(id=="load_dependent_friction"){D s=r.u()<.3?-1:1;a("exponent",s>0?.15*k:-min(.45,.15*k));a("elsewhere",0);}
 else if(id=="anisotropic_friction")a("ratio",exp(r.sg()*min(.95,k*log(1.4))));
 else if(id=="finger_friction_mismatch")a("mismatch",r.sg()*.15*k);
 else if(id=="wear_drift")a("rate_per_trial",r.sg()*.0006*k);
 else if(id=="torsional_friction"){D s=r.sg();a("radius_change_m",s>0?.002*k:-min(.0055,.002*k));}
 else if(id=="pressure_offset"){a("offset_x_m",r.sg()*min(.006,.002*k));D k2=r.lu(1,4);if(r.u()<.6)a("offset_z_m",r.sg()*.001*k2);}
 else if(id=="face_tilt"){int w=r.i(4);if(w==0)a("slope_rad",r.sg()*.01*k);else if(w==1)a("friction_gradient_1_m",r.sg()*6*k);else if(w==2)a("grip_gradient_1_m",r.sg()*4*k);else a("grip_gradient_n_m",r.sg()*100*k);}
 else if(id=="face_waviness"){int w=r.i(3);if(w!=1)a("amplitude",r.sg()*.1*k);if(w>0)a("grip_n",r.sg()*.5*r.lu(1,4));a("wavelength_m",r.lu(.004,.012));a("phase_rad",r.u(-3.1,3.1));}
 else if(id=="plate_tilt"){int w=r.i(3);if(w!=1)a("pitch_rad",r.sg()*.01*k);if(w!=0)a("yaw_rad",r.sg()*.01*r.lu(1,4));if(r.u()<.5)a("line_rad",r.sg()*.01*r.lu(1,4));}
 else if(id=="adhesion")a("pull_off_n",k);
 else if(id=="grip_force_loss"){if(r.u()<.5)a("fraction",(r.u()<.8?1:-1)*.1*k);else a("offset_n",(r.u()<.8?1:-1)*k);}
 else if(id=="grip_force_lag"){if(r.u()<.5){a("drop",.12*k);a("time_s",.1*r.lu(.5,2));a("knee_m_s",1e-3);a("sharpness",1);}else{a("drop_1_m",min(25.0,5*k));a("time_s",.1*r.lu(.5,2));}}
 else if(id=="mass_error"){int w=r.i(3);if(w!=1)a("fraction",r.sg()*.1*k);if(w!=0)a("com_x_m",r.sg()*.004*r.lu(1,4));}
 else if(id=="external_force"){int w=1+r.i(7);for(int j=0;j<3;j++)if(w>>j&1)a(j==0?"x_n":j==1?"y_n":"z_n",r.sg()*.5*r.lu(1,4));if(r.u()<.5)a("stiffness_n_m",r.sg()*20*r.lu(1,4));if(r.u()<.4)a("at_x_m",r.sg()*r.u(.01,.04));}
 else if(id=="gravity_tilt"){int w=r.i(3);if(w!=1)a("about_x_rad",r.sg()*.05*k);if(w!=0)a("about_y_rad",r.sg()*.05*r.lu(1,4));}
 else if(id=="sensor_bias"){const char*b[]={"finger1","finger2","pusher"};const char*c[]={"_fx_n","_fy_n","_fz_n","_tx_nm","_ty_nm","_tz_nm"};int n=1+r.i(4);
  vector<int>ch;for(int j=0;j<18;j++)ch.push_back(j);r.sh(ch);for(int j=0;j<n;j++){D kk=r.lu(1,4);int q=ch[j];D typ=q%6<3?.25:.003;if(q>=12)kk=max(kk,2.0);a((string(b[q/6])+c[q%6]).c_str(),r.sg()*typ*kk);}}
 else if(id=="sensor_gain"){const char*b[]={"finger1","finger2","pusher"};int w=1+r.i(7);for(int j=0;j<3;j++)if(w>>j&1)a(b[j],r.sg()*.05*r.lu(1,4));}
 else if(id=="sensor_misalignment"){const char*b[]={"finger1_x_rad","finger1_z_rad","finger2_x_rad","finger2_z_rad","pusher_y_rad","pusher_z_rad","finger1_y_rad","finger2_y_rad"};vector<int>c;for(int j=0;j<8;j++)c.push_back(j);r.sh(c);int n=1+r.i(3);for(int j=0;j<n;j++)a(b[c[j]],r.sg()*.03*r.lu(1,4));}
 else if(id=="sensor_crosstalk"){const char*b[]={"finger1_to_x","finger2_to_x","finger1_to_z","finger2_to_z","pusher_to_y","pusher_to_z","finger1_to_tx_m","finger2_to_tz_m","finger1_to_ty_m","finger2_to_ty_m","pusher_to_ty_m"};vector<int>c;for(int j=0;j<11;j++)c.push_back(j);r.sh(c);int n=1+r.i(3);for(int j=0;j<n;j++)a(b[c[j]],r.sg()*(c[j]<6?.02:c[j]==10?.001:.0005)*r.lu(1,4));}
 else if(id=="mocap_latency")a("latency_s",.02*k);
 else if(id=="x_wrist_backlash")a("half_gap_rad",.0025*k);
 else if(id=="x_pad_warming"){a("stiffness_loss",min(.8,.3*k));a("friction_gain",r.u(.03,.12)*k/2);a("trials",r.u(5,20));}
 else if(id=="x_cable_hysteresis"){a("yield_n",.7*k);a("stiffness_n_m",r.lu(400,2500));a("spring_n_m",r.lu(10,60));}
 else if(id=="x_pusher_patchy"){a("amplitude",r.sg()*min(.6,.18*k));a("length_m",r.lu(.002,.006));a("centre_m",r.u(-.003,.003));}
 else if(id=="x_drive_stick_slip"){a("lag_m",3e-5*k);a("period_m",r.lu(4e-4,1.6e-3));}
 else if(id=="x_grip_cycle"){a("share",.02*k);a("frequency_hz",r.lu(2,12));}
 else{fprintf(stderr,"unknown effect %s\n",id.c_str());exit(2);}
 (void)side;return e;}

struct Trial{bool piv;D grip,speed,slope,off;int run;};
struct Prof{D t0,V,ta,S;D tc()const{return S/V-ta;}D end()const{return t0+2*ta+max(0.0,tc());}
 D vel(D t)const{t-=t0;D c=tc();if(t<=0)return 0;if(t<ta)return V*.5*(1-cos(M_PI*t/ta));if(t<ta+c)return V;t-=ta+c;if(t<ta)return V*.5*(1+cos(M_PI*t/ta));return 0;}
 D pos(D t)const{t-=t0;D c=tc();if(t<=0)return 0;auto r=[&](D s){return V*.5*(s-ta/M_PI*sin(M_PI*s/ta));};if(t<ta)return r(t);if(t<ta+c)return V*ta*.5+V*(t-ta);t-=ta+c;if(t<ta)return V*(ta*.5+c)+V*.5*(t+ta/M_PI*sin(M_PI*t/ta));return V*(ta+c);}};

int main(int argc,char**argv){
 if(argc<6){fprintf(stderr,"usage: sim10 NUMBER SEED EFFECTS FOLDER KEY.json\n");return 2;}
 int number=atoi(argv[1]);uint64_t seed=strtoull(argv[2],0,10);string el=argv[3],folder=argv[4];
 D dt=getenv("SIM10_DT")?atof(getenv("SIM10_DT")):2e-5;bool truth=getenv("SIM10_TRUE")!=0;int maxtr=getenv("SIM10_TRIALS")?atoi(getenv("SIM10_TRIALS")):1000000;
 Rng R(seed*7919+13);
 // ---- the rig
 D dens[]={1040,1180,1410,2700};D rho=dens[R.i(4)];D Lx=round(R.u(80,120))/1000,side=round(R.u(40,60))/2000;D massn=round(rho*Lx*side*side*1e4)/1e4;
 D diam=round(R.u(16,22))/1000,a=diam/2;D lline=round(side*1000+R.u(2,8))/1000;
 D rate=R.u()<.5?250:500;
 D ktp=R.lu(1e4,3e6),knp=min(8e6,ktp*R.u(1.5,4));int prof=R.i(3),kind=R.i(3);int kindp=R.i(2);
 D kps=R.lu(3e5,5e6),kratio=R.u(.4,1.0);
 D muf=R.u(.32,.6),mup=R.u(.16,.32),scat=R.u(.01,.04);
 D jawm=R.u(.1,.25),klat=R.lu(5e5,4e6);
 D ffn=R.u(.01,.035),ftn=R.u(2e-4,5e-4),pfn=R.u(.025,.07),ptn=R.u(8e-4,2.5e-3);
 D ffu=R.u(.12,.3),ftu=R.u(.002,.004),pfu=R.u(.35,.8),ptu=R.u(.015,.04);D posn=R.u(2e-5,5e-5),rotn=R.u(1.5e-4,4e-4);
 D off[18];for(int i=0;i<18;i++){D u=i<12?(i%6<3?ffu:ftu):(i%6<3?pfu:ptu);off[i]=R.nc(.22*u,.6*u);}
 D poff[6];for(int i=0;i<6;i++)poff[i]=R.nc(.7,1.5)*(i<3?posn:rotn);
 D clock=R.u(-.45,.45)/rate;D sqp=R.nc(5e-4,1e-3),sqy=R.nc(5e-4,1e-3),sql=R.nc(5e-4,1e-3);
 D dpk=R.nc(.04,.08),dpm=R.nc(.004,.01);D griperr=R.nc(.003,.006),gripsd=R.u(.001,.004);D graspoff=R.u()<.35?R.sg()*round(R.u(3,8))/1000:0;
 D gap=R.u(2.5e-4,6e-4);D t0=R.u(.25,.5),ta=R.u(.05,.2),tend=R.u(.2,.4),hold=R.u(.3,2);
 D dist=R.u(.009,.014),angle=R.u(.24,.36);
 // ---- effects
 {string s=el;size_t p=0;while(p<=s.size()&&s!="none"){size_t q=s.find(',',p);if(q==string::npos)q=s.size();string id=s.substr(p,q-p);Rng E(seed*104729+hash<string>()(id));effs.push_back(draw(id,E,side));p=q+1;}}
 if(has("anisotropic_friction")&&kind==2)kind=0; // Iwan's radial return does not follow an ellipse's normals
 // ---- plan
 vector<Trial>tr;{
  vector<D>gall={15,18,20,22,25,28,30,32,35,38},gr;R.sh(gall);int ng=2+R.i(3);for(int i=0;i<ng;i++)gr.push_back(gall[i]);sort(gr.begin(),gr.end());
  if(gr.back()-gr[0]<8)gr.back()=gr[0]+10;
  vector<D>sall={.006,.008,.01,.012,.015,.02,.025,.03},sp;R.sh(sall);int ns=2+R.i(2);for(int i=0;i<ns;i++)sp.push_back(sall[i]);
  vector<vector<D>>sls={{0},{-10,0,10},{-20,0,20},{0,15},{-15,15},{-20,-10,0,10,20},{0,-12}};auto sl=sls[R.i(7)];
  bool piv=R.u()<.8;if(has("torsional_friction"))piv=true;int reps=2+(R.u()<.4);int nc=reps==2?12+R.i(9):10+R.i(8);int np=piv?(int)round(nc*R.u(.25,.5)):0;int nl=nc-np;
  vector<Trial>lin,pv;for(D g:gr)for(D s:sp)for(D q:sl)lin.push_back({false,g,s,q*M_PI/180,0,0});
  R.sh(lin);while((int)lin.size()<nl){Trial t=lin[R.i(lin.size())];t.grip=gall[R.i(10)];t.speed=sall[R.i(8)];bool dup=false;for(auto&o:lin)if(o.grip==t.grip&&o.speed==t.speed&&o.slope==t.slope)dup=true;if(!dup)lin.push_back(t);}
  lin.resize(nl);
  vector<D>wall={5,7.5,10,12,15,20},ws;R.sh(wall);for(int i=0;i<2;i++)ws.push_back(wall[i]);vector<D>oall={0,5,10,15,20},os;R.sh(oall);for(int i=0;i<2;i++)os.push_back(oall[i]);
  for(D g:gr)for(D w:ws)for(D o:os)pv.push_back({true,g,w*M_PI/180,0,o/1000,0});
  R.sh(pv);if((int)pv.size()>np)pv.resize(np);while((int)(lin.size()+pv.size())<10){Trial t=lin[0];t.grip=gall[R.i(10)];t.speed=sall[R.i(8)];bool dup=false;for(auto&o:lin)if(o.grip==t.grip&&o.speed==t.speed&&o.slope==t.slope)dup=true;if(!dup)lin.push_back(t);}
  vector<Trial>cs=lin;cs.insert(cs.end(),pv.begin(),pv.end());int order=R.i(3);
  auto key=[](const Trial&x,const Trial&y){if(x.piv!=y.piv)return x.piv<y.piv;if(x.grip!=y.grip)return x.grip<y.grip;if(x.speed!=y.speed)return x.speed<y.speed;if(x.slope!=y.slope)return x.slope<y.slope;return x.off<y.off;};
  sort(cs.begin(),cs.end(),key);
  if(order==0)for(auto&c:cs)for(int k=0;k<reps;k++){c.run=k;tr.push_back(c);}
  else for(int k=0;k<reps;k++){if(order==2)R.sh(cs);for(auto&c:cs){c.run=k;tr.push_back(c);}}
  while((int)tr.size()<24){Trial c=cs[tr.size()%cs.size()];c.run=reps;tr.push_back(c);}
 }
 D gref=0;for(auto&t:tr)gref+=t.grip/tr.size();
 mkdir(folder.c_str(),0755);mkdir((folder+"/trials").c_str(),0755);
 bool anypiv=false,anylin=false;for(auto&t:tr){anypiv|=t.piv;anylin|=!t.piv;}
 {FILE*f=fopen((folder+"/dataset.toml").c_str(),"w");
 fprintf(f,"format = \"stickslip-dataset/1\"\nname = \"sim10_%d\"\nsample_rate_hz = %.1f\ngravity_m_s2 = [0.0, 0.0, -9.81]\n\n[[objects]]\nid = \"block\"\nshape = \"prism\"\nlength_m = %.4g\nside_m = %.4g\nmass_kg = %.4f\n\n[fingers]\ncontact = \"disc\"\ndiameter_m = %.4g\n",number,rate,Lx,side,massn,diam);
 if(anylin)fprintf(f,"\n[pushers.linear_push]\ncontact = \"plane\"\n");if(anypiv)fprintf(f,"\n[pushers.pivot]\ncontact = \"line\"\nlength_m = %.4g\n",lline);
 fprintf(f,"\n[sensors.finger]\nforce_noise_n = %.4f\nforce_uncertainty_n = %.3f\ntorque_noise_nm = %.6f\ntorque_uncertainty_nm = %.5f\n\n[sensors.pusher]\nforce_noise_n = %.4f\nforce_uncertainty_n = %.3f\ntorque_noise_nm = %.6f\ntorque_uncertainty_nm = %.5f\n\n[sensors.pose]\nposition_noise_m = %.7f\nrotation_noise_rad = %.6f\n",ffn,ffu,ftn,ftu,pfn,pfu,ptn,ptu,posn,rotn);fclose(f);}
 FILE*ft=fopen((folder+"/trials.csv").c_str(),"w");
 fprintf(ft,"trial,file,object,primitive,grip_n,speed_m_s,speed_rad_s,slope_rad,pusher_offset_m,run,pusher_x_m,pusher_y_m,pusher_z_m,pusher_qw,pusher_qx,pusher_qy,pusher_qz\n");
 // ---- true body
 D mass=massn*(1+P("mass_error","fraction")),comx=P("mass_error","com_x_m");
 D Ix=mass*side*side/6,Iy=mass*(Lx*Lx+side*side)/12,Iz=Iy;
 V g={0,0,-9.81};{D ax=P("gravity_tilt","about_x_rad"),ay=P("gravity_tilt","about_y_rad");g=mul(qm(qmul(qv({0,ay,0}),qv({ax,0,0}))),g);}
 const int NP=30;D px[NP],pz[NP],pw[NP];{int rn[3]={4,10,16},q=0,c=0;D sw=0;for(int k=0;k<3;k++){D f=(c+rn[k]*.5)/30;for(int j=0;j<rn[k];j++){D th=2*M_PI*(j+.3*k)/rn[k];px[q]=sqrt(f)*cos(th);pz[q]=sqrt(f)*sin(th);pw[q]=prof==0?1:prof==1?1-.85*f:.45+f;sw+=pw[q];q++;}c+=rn[k];}for(int i=0;i<NP;i++)pw[i]/=sw;}
 D arad=a+P("torsional_friction","radius_change_m");D ofx=P("pressure_offset","offset_x_m"),ofz=P("pressure_offset","offset_z_m");
 D slope_f=P("face_tilt","slope_rad");D latency=P("mocap_latency","latency_s");
 D mism=P("finger_friction_mismatch","mismatch");D ratio=P("anisotropic_friction","ratio",1);
 vector<array<D,2>>mus;D sat_max=0;
 int nt=min((int)tr.size(),maxtr);
 for(int it=0;it<nt;it++){const Trial&T=tr[it];Rng r(seed*1000003+977*it+5);
  D nmu=1+scat*r.nc(1,2.5),nmp=1+scat*r.nc(1,2.5),n1=1+.3*scat*r.nc(1,2.5),n2=1+.3*scat*r.nc(1,2.5);D gs=1+griperr+gripsd*r.nc(1,2.5);
  D plx=r.nc(1e-4,2e-4),plz=r.nc(1e-4,2e-4),plp=r.nc(4e-4,8e-4),ply=r.nc(1e-4,2e-4);
  D wear=1+P("wear_drift","rate_per_trial")*it;
  D warm=1-exp(-it/P("x_pad_warming","trials",10));D ksc=1-P("x_pad_warming","stiffness_loss")*warm;D mw=1+P("x_pad_warming","friction_gain")*warm;
  D mubase=muf*nmu*wear*mw;D mu1=mubase*n1*(1+dpm)*(1+mism),mu2=mubase*n2*(1-dpm)*(1-mism),mupt=mup*nmp;mus.push_back({mubase,mupt});
  D kt=ktp*ksc,kn=knp*ksc;
  D wmode=sqrt(2*kt/mass);D btp=min(.6/wmode,3e-3),bnp=min(.5/sqrt(2*kn/mass),3e-3);D wpu=sqrt(kps/mass);D bpu=.5/wpu;
  Con f1,f2,pu;
  for(Con*c:{&f1,&f2}){c->clear();c->n=NP;D s=c==&f1?1+dpk:1-dpk;for(int i=0;i<NP;i++){c->x[i]=px[i]*arad+ofx;c->z[i]=pz[i]*arad+ofz;c->kn[i]=kn*pw[i]*s;c->kt[i]=kt/NP*s;c->mb[i]=1;c->ad[i]=P("adhesion","pull_off_n")*pw[i];c->age[i]=0;}}
  pu.clear();D b=side/2;
  if(!T.piv){pu.n=25;D w5[5]={.125,.25,.25,.25,.125};for(int i=0;i<25;i++){int u=i/5,v=i%5;pu.x[i]=b*(u-2)*.5;pu.z[i]=b*(v-2)*.5;D w=w5[u]*w5[v];pu.kn[i]=kps*w;pu.kt[i]=kps*kratio*w;}}
  else{pu.n=12;D h=min(lline,side)/2;for(int i=0;i<12;i++){pu.x[i]=h*(2*i+1-12)/12;pu.z[i]=0;pu.kn[i]=kps/12;pu.kt[i]=kps*kratio/12;}}
  for(int i=0;i<NM;i++){pu.mb[i]=1;pu.ad[i]=0;pu.age[i]=0;}
  V Pp;Q Pq;if(!T.piv){Pp={graspoff-Lx/2-gap,0,0};Pq={1,0,0,0};}else{Pp={graspoff-.45*Lx+T.off,0,-b-gap};Pq={M_SQRT1_2,0,-M_SQRT1_2,0};}
  Pp.x=round(Pp.x*1e6)/1e6;Pp.z=round(Pp.z*1e6)/1e6;
  M Rp;V ld={0,1,0};
  if(!T.piv)Rp=qm(qmul(Pq,qmul(qv({0,sqp+P("plate_tilt","pitch_rad"),0}),qv({0,0,sqy+P("plate_tilt","yaw_rad")}))));
  else{Rp=qm(qmul(Pq,qv({0,0,sql+P("plate_tilt","line_rad")})));ld=Rp.b;}
  Prof pr{t0+r.u(0,.1),T.piv?T.speed:T.speed,ta,T.piv?angle:min(dist,2.2*T.speed)};if(pr.S/pr.V<ta)pr.ta=pr.S/pr.V;
  D tfin=pr.end()+tend;int ns=(int)floor(tfin*rate);
  // state (geometric centre first, then the centre of mass)
  Q q=qv({0,plp*.5,r.nc(3e-4,6e-4)*.3});M Ro=qm(q);V pc={graspoff+plx,ply*.1,plz};V p=pc+comx*Ro.a;V v={0,0,0},om={0,0,0};
  V p0=pc;
  D Fg0=T.grip;D jw=b-Fg0/kn,jv=0,jc=0,jcv=0;if(slope_f!=0)jw+=slope_f*(-pc.x);
  D gact=0;bool first=true;D slipd=0,bl=0,blv=0;V cab={0,0,0},cabd0={0,0,0};bool cab0=true;
  D settle=.3;int sps=(int)llround(1/(rate*dt));int nsettle=(int)llround(settle/dt);long total=nsettle+(long)(ns-1)*sps+1;
  // pose history
  int hs=max(1,(int)llround(2e-4/dt));vector<array<D,7>>H;H.reserve(total/hs+2);
  struct Row{D t;V gp;Q gq;V F[3],Tq[3];};vector<Row>rows;rows.reserve(ns);
  V cl={-cos(T.slope),0,sin(T.slope)};D lag=P("x_drive_stick_slip","lag_m"),per=P("x_drive_stick_slip","period_m",1e-3);D gph=r.u(0,2*M_PI);
  D scS=T.piv?1/(.45*Lx):1;
  Fr F1,F2,FP;
  for(Fr*f:{&F1,&F2}){f->kind=kind;f->bn=bnp;f->bt=btp;f->excess=P("static_friction","excess");f->vs=P("static_friction","stribeck_speed_m_s",.002);f->visc=P("viscous_friction","viscosity_s_m");f->strength=P("dwell_strengthening","strengthening");f->cut=P("dwell_strengthening","cutoff_s",.05);f->ren=P("dwell_strengthening","renewal_m",2e-5);}
  FP.kind=kindp;FP.bn=bpu;FP.bt=bpu;FP.mu1=FP.mu2=mupt;
  D expo=P("load_dependent_friction","exponent");D sr=sqrt(ratio);
  D fgr=P("face_tilt","friction_gradient_1_m"),ggn=P("face_tilt","grip_gradient_n_m"),gg1=P("face_tilt","grip_gradient_1_m");
  D wa=P("face_waviness","amplitude"),wl=P("face_waviness","wavelength_m",.008),wp=P("face_waviness","phase_rad"),wg=P("face_waviness","grip_n");
  D loss=P("grip_force_loss","fraction"),losso=P("grip_force_loss","offset_n");D drop=P("grip_force_lag","drop"),lt=P("grip_force_lag","time_s"),knee=P("grip_force_lag","knee_m_s",1e-3),shp=P("grip_force_lag","sharpness",1),d1=P("grip_force_lag","drop_1_m");
  V ext={P("external_force","x_n"),P("external_force","y_n"),P("external_force","z_n")};D extk=P("external_force","stiffness_n_m"),exta=P("external_force","at_x_m");D extl=len(ext);V extu=extl>0?(1/extl)*ext:V{0,0,0};
  D blg=P("x_wrist_backlash","half_gap_rad");D cy=P("x_cable_hysteresis","yield_n"),ck=P("x_cable_hysteresis","stiffness_n_m"),ck2=P("x_cable_hysteresis","spring_n_m");
  D pam=P("x_pusher_patchy","amplitude"),pal=P("x_pusher_patchy","length_m",.003),pac=P("x_pusher_patchy","centre_m");
  D gcs=P("x_grip_cycle","share"),gcf=P("x_grip_cycle","frequency_hz",5);
  D xpatch=0,slipv=0;D cjaw=2*.7*sqrt(2*kn*jawm*1.0),clat=2*.3*sqrt((klat+2*kn)*2*jawm);
  D slo=sqrt(1+slope_f*slope_f);
  for(long n=0;n<total;n++){
   D t=(n-nsettle)*dt;
   if(n==nsettle)for(Con*c:{&f1,&f2})for(int i=0;i<NP;i++)c->age[i]=max(c->age[i],hold);
   // gripper: commanded pose, and the true one
   D s=pr.pos(t),sv=pr.vel(t),st=s,svt=sv;
   if(lag>0){D u=s/(per*scS);u-=floor(u);D A=lag*scS;D rec=.15;if(u<1-rec){st-=A*u/(1-rec);svt-=sv*A/(per*scS)/(1-rec);}else{D w=(u-1+rec)/rec;st-=A*.5*(1+cos(M_PI*w));svt+=sv*A*.5*M_PI*sin(M_PI*w)/(rec*per*scS);}}
   V gp,gv={0,0,0},gw={0,0,0};Q gq={1,0,0,0};V gpc;Q gqc={1,0,0,0};
   if(!T.piv){gp=st*cl;gv=svt*cl;gpc=s*cl;}else{gp={0,0,0};gpc=gp;gq=qv({0,-st,0});gw={0,-svt,0};gqc=qv({0,-s,0});}
   if(blg>0){gq=qmul(gq,qv({0,bl,0}));gw.y+=blv;}
   M Rg=T.piv||blg>0?qm(gq):M{{1,0,0},{0,1,0},{0,0,1}};
   Ro=qm(q);pc=p-comx*Ro.a;
   M R_=tmm(Rg,Ro);V c=tmul(Rg,pc-gp);V W=tmul(Rg,om-gw),V0=tmul(Rg,v-gv-cross(om,p-gp));
   // command of the grip
   D xp=-dot(R_.a,c);xpatch=xp;
   D cmd=T.grip*gs*(1-loss)-losso;
   cmd+=ggn*xp+gg1*xp*T.grip;if(wg!=0)cmd+=wg*sin(2*M_PI*xp/wl+wp);if(gcs!=0)cmd*=1+gcs*sin(2*M_PI*gcf*t+gph);
   if(drop!=0||d1!=0){D vv=pow(slipv,shp),kk=pow(knee,shp);cmd*=1-drop*vv/(vv+kk)-d1*slipd;}
   if(cmd<1)cmd=1;
   if(lt>0&&!first)gact+=(cmd-gact)*(1-exp(-dt/lt));else gact=cmd;first=false;
   // friction coefficients of the fingers
   D mx=1;if(wa!=0)mx*=1+wa*sin(2*M_PI*xp/wl+wp);
   V FO={0,0,0},TO={0,0,0};V Fm[3],Tm[3];D Ny[2];
   for(int k=0;k<2;k++){Con&C=k?f2:f1;Fr&F=k?F2:F1;D sg=k?-1:1;
    V no={-slope_f/slo,sg/slo,0};V nn=mul(R_,no);D d=b/slo+dot(nn,c);D yf=jc+sg*jw;
    D y0=d/nn.y,ix=-nn.x/nn.y,iz=-nn.z/nn.y;V ra={1,ix,0},rb={0,iz,1},r0={0,y0,0};
    Lin de={sg*(y0-yf),sg*ix,sg*iz};
    V vc=V0+cross(W,r0),va=cross(W,ra),vb=cross(W,rb);D in=1/fabs(nn.y);D yfv=jcv+sg*jv;
    Lin dd={dot(nn,vc)*in-sg*yfv,dot(nn,va)*in,dot(nn,vb)*in};
    V t1=R_.a-dot(R_.a,nn)*nn;t1=(1/len(t1))*t1;V t2=cross(t1,nn);if(dot(t2,R_.c)<0)t2=-1*t2;
    // bristles are on the finger, and the object's motion bends them; force on the object is against it
    Lin l1={dot(t1,vc),dot(t1,va),dot(t1,vb)},l2={dot(t2,vc),dot(t2,va),dot(t2,vb)};
    D m=(k?mu2:mu1)*mx;if(expo!=0){D Nc=max(gact,1.0);m*=pow(Nc/gref,-expo);}
    F.mu1=m*sr;F.mu2=m/sr;
    if(fgr!=0){V ox={R_.a.x,R_.a.y,R_.a.z};D c0=-dot(ox,c);for(int i=0;i<NP;i++){D g_=1+fgr*(c0+ox.x*C.x[i]+ox.z*C.z[i]);C.mb[i]=g_<.1?.1:g_;}}
    Sum S=step_contact(C,de,dd,l1,l2,F,dt);
    V f=(-S.N)*nn-S.f1*t1-S.f2*t2;V fx=(-S.xN)*nn-S.x1*t1-S.x2*t2,fz=(-S.zN)*nn-S.z1*t1-S.z2*t2;
    V tq=cross(ra,fx)+cross(rb,fz);Fm[k]=f;Tm[k]=tq;Ny[k]=-sg*f.y;
    V fw=mul(Rg,f),tw=mul(Rg,tq)+cross(gp+mul(Rg,r0)-p,fw);FO=FO+fw;TO=TO+tw;
    if(k==0){slipv=sqrt(l1.c*l1.c+l2.c*l2.c+pow(.667*a*W.y,2));}
   }
   if(n>=nsettle&&slipv>1e-4)slipd+=slipv*dt;
   if(blg>0){V mo=tmul(Rg,TO+cross(p-gp,FO));D J=2e-3,Ks=2e4,Cb=6.3;D cl_=max(-blg,min(blg,bl));D acc=(-mo.y-Ks*(bl-cl_)-Cb*blv)/J;blv+=acc*dt;bl+=blv*dt;}
   // pusher
   V fp={0,0,0},tp={0,0,0};
   if(t>-.02){
    if(!T.piv){V q0=tmul(Rp,pc-Lx/2*Ro.a-Pp),qa=tmul(Rp,Ro.b),qb=tmul(Rp,Ro.c);
     D mn=q0.x-b*(fabs(qa.x)+fabs(qb.x));
     if(mn<0){V rc=pc-Lx/2*Ro.a-p;V vc=tmul(Rp,v+cross(om,rc)),va=tmul(Rp,cross(om,Ro.b)),vb=tmul(Rp,cross(om,Ro.c));
      Lin de={-q0.x,-qa.x,-qb.x},dd={-vc.x,-va.x,-vb.x},l1={vc.y,va.y,vb.y},l2={vc.z,va.z,vb.z};
      if(pam!=0)for(int i=0;i<25;i++)pu.mb[i]=1+pam*tanh((q0.z+qa.z*pu.x[i]+qb.z*pu.z[i]-pac)/pal);
      Sum S=step_contact(pu,de,dd,l1,l2,FP,dt);
      V F={S.N,-S.f1,-S.f2},FX={S.xN,-S.x1,-S.x2},FZ={S.zN,-S.z1,-S.z2};
      fp=mul(Rp,F);tp=mul(Rp,cross(q0,F)+cross(qa,FX)+cross(qb,FZ));}
     else pu.clear();
    }else{V r0=tmul(Ro,Pp-pc),ra=tmul(Ro,ld);
     D mxd=r0.z+b+.5*side*fabs(ra.z);
     if(mxd>0){V rc=Pp-p;V vc=tmul(Ro,v+cross(om,rc)),va=tmul(Ro,cross(om,ld));
      Lin de={r0.z+b,ra.z,0},dd={-vc.z,-va.z,0},l1={vc.x,va.x,0},l2={vc.y,va.y,0};
      if(pam!=0)for(int i=0;i<12;i++)pu.mb[i]=1+pam*tanh((r0.x+.45*Lx-T.off+pu.x[i]-pac)/pal);
      Sum S=step_contact(pu,de,dd,l1,l2,FP,dt);
      V F={-S.f1,-S.f2,S.N},FX={-S.x1,-S.x2,S.xN};fp=mul(Ro,F);tp=cross(ld,mul(Ro,FX));}
     else pu.clear();}
   }
   Fm[2]=fp;Tm[2]=tp;
   // log
   if(n%hs==0)H.push_back({pc.x,pc.y,pc.z,q.w,q.x,q.y,q.z});
   if(n>=nsettle&&(n-nsettle)%sps==0){Row w;w.t=t;w.gp=gpc;w.gq=gqc;for(int k=0;k<3;k++){w.F[k]=Fm[k];w.Tq[k]=Tm[k];}rows.push_back(w);}
   // body
   V Ft=FO+fp+mass*g,Tt=TO+tp+cross(Pp-p,fp);
   if(extl>0){D m=extl-extk*dot(pc-p0,extu);V e=m*extu;Ft=Ft+e;Tt=Tt+cross(pc+exta*Ro.a-p,e);}
   if(cy>0){V e=tmul(Rg,pc+Lx/2*Ro.a-gp);if(cab0){cabd0=e;cab0=false;}V ev=V0+cross(W,e);cab=cab+(ck*dt)*ev;D l=len(cab);if(l>cy)cab=(cy/l)*cab;V ff=mul(Rg,-1*cab-ck2*(e-cabd0));Ft=Ft+ff;Tt=Tt+cross(pc+Lx/2*Ro.a-p,ff);}
   if(t<-.12){D c1=40;Ft=Ft-(c1*mass)*v;Tt=Tt-(c1*Iy)*om;}
   v=v+(dt/mass)*Ft;V wb=tmul(Ro,om),tb=tmul(Ro,Tt);V Iw={Ix*wb.x,Iy*wb.y,Iz*wb.z};V gyr=cross(wb,Iw);
   wb=wb+dt*V{(tb.x-gyr.x)/Ix,(tb.y-gyr.y)/Iy,(tb.z-gyr.z)/Iz};om=mul(Ro,wb);
   p=p+dt*v;q=qn(qmul(qv(dt*om),q));
   // jaw
   jv+=dt*((Ny[0]+Ny[1]-2*gact)-2*cjaw*jv)/(2*jawm);jw+=dt*jv;
   jcv+=dt*(Ny[0]-Ny[1]-klat*jc-clat*jcv)/(2*jawm);jc+=dt*jcv;
   if(!(fabs(p.x)<1)){fprintf(stderr,"set %d trial %d diverged\n",number,it);return 3;}
  }
  // ---- write
  char id[16];snprintf(id,16,"t%04d",it);
  char sp_[32]="",sr_[32]="",sl_[32]="",of_[32]="";
  if(T.piv){snprintf(sr_,32,"%.6g",T.speed);snprintf(of_,32,"%.4g",T.off);}else{snprintf(sp_,32,"%.4g",T.speed);snprintf(sl_,32,"%.6g",T.slope);}
  fprintf(ft,"%s,trials/%s.csv,block,%s,%g,%s,%s,%s,%s,%d,%.6f,0,%.6f,%.9g,0,%.9g,0\n",id,id,T.piv?"pivot":"linear_push",T.grip,sp_,sr_,sl_,of_,T.run,Pp.x,Pp.z,Pq.w,Pq.y);
  FILE*f=fopen((folder+"/trials/"+id+".csv").c_str(),"w");
  fprintf(f,"t_s,grip_cmd_n,gripper_x_m,gripper_y_m,gripper_z_m,gripper_qw,gripper_qx,gripper_qy,gripper_qz,object_x_m,object_y_m,object_z_m,object_qw,object_qx,object_qy,object_qz");
  const char*nb[]={"finger1","finger2","pusher"};for(int k=0;k<3;k++)fprintf(f,",%s_fx_n,%s_fy_n,%s_fz_n,%s_tx_nm,%s_ty_nm,%s_tz_nm",nb[k],nb[k],nb[k],nb[k],nb[k],nb[k]);fprintf(f,"\n");
  V mis[3];for(int k=0;k<3;k++){string b_=nb[k];mis[k]={P("sensor_misalignment",(b_+"_x_rad").c_str()),P("sensor_misalignment",(b_+"_y_rad").c_str()),P("sensor_misalignment",(b_+"_z_rad").c_str())};}
  D xt[3][5];for(int k=0;k<3;k++){string b_=nb[k];xt[k][0]=P("sensor_crosstalk",(b_+(k<2?"_to_x":"_to_y")).c_str());xt[k][1]=P("sensor_crosstalk",(b_+"_to_z").c_str());xt[k][2]=P("sensor_crosstalk",(b_+"_to_tx_m").c_str());xt[k][3]=P("sensor_crosstalk",(b_+"_to_ty_m").c_str());xt[k][4]=P("sensor_crosstalk",(b_+"_to_tz_m").c_str());}
  D gn[3]={1+P("sensor_gain","finger1"),1+P("sensor_gain","finger2"),1+P("sensor_gain","pusher")};
  D bias[18];const char*ch[]={"_fx_n","_fy_n","_fz_n","_tx_nm","_ty_nm","_tz_nm"};for(int k=0;k<18;k++)bias[k]=P("sensor_bias",(string(nb[k/6])+ch[k%6]).c_str());
  for(auto&w:rows){
   D th=(w.t+settle-latency-clock);if(truth)th=w.t+settle;D u=th/(hs*dt);int i0=max(0,min((int)H.size()-2,(int)floor(u)));D fr=max(0.0,min(1.0,u-i0));D o[7];for(int k=0;k<7;k++)o[k]=H[i0][k]*(1-fr)+H[i0+1][k]*fr;
   Q oq=qn({o[3],o[4],o[5],o[6]});
   V pn={r.n()*posn+poff[0],r.n()*posn+poff[1],r.n()*posn+poff[2]};V rn_={r.n()*rotn+poff[3],r.n()*rotn+poff[4],r.n()*rotn+poff[5]};
   if(!truth){o[0]+=pn.x;o[1]+=pn.y;o[2]+=pn.z;oq=qn(qmul(oq,qv(rn_)));}
   fprintf(f,"%.7g,%g,%.8g,%.8g,%.8g,%.9g,0,%.9g,0,%.7g,%.7g,%.7g,%.9g,%.7g,%.9g,%.7g",w.t,T.grip,w.gp.x,w.gp.y,w.gp.z,w.gq.w,w.gq.y,o[0],o[1],o[2],oq.w,oq.x,oq.y,oq.z);
   for(int k=0;k<3;k++){V F=w.F[k],Q_=w.Tq[k];
    D nz[6];for(int j=0;j<6;j++)nz[j]=r.n()*(k<2?(j<3?ffn:ftn):(j<3?pfn:ptn))+off[6*k+j]+bias[6*k+j];
    if(!truth){M m=qm(qv(mis[k]));F=mul(m,F);Q_=mul(m,Q_);
     D nf=k<2?F.y:F.x;D e0=xt[k][0]*nf,e1=xt[k][1]*nf;if(k<2)F.x+=e0;else F.y+=e0;F.z+=e1;Q_.x+=xt[k][2]*nf;Q_.y+=xt[k][3]*nf;Q_.z+=xt[k][4]*nf;
     F=gn[k]*F;Q_=gn[k]*Q_;F=F+V{nz[0],nz[1],nz[2]};Q_=Q_+V{nz[3],nz[4],nz[5]};}
    fprintf(f,truth?",%.9g,%.9g,%.9g,%.9g,%.9g,%.9g":",%.6g,%.6g,%.6g,%.6g,%.6g,%.6g",F.x,F.y,F.z,Q_.x,Q_.y,Q_.z);}
   fprintf(f,"\n");}
  fclose(f);
 }
 fclose(ft);
 FILE*k=fopen(argv[5],"w");const char*kinds[]={"lugre","elasto_plastic","iwan"};const char*profs[]={"flat","parabolic","edge_heavy"};
 fprintf(k,"{\n \"number\": %d,\n \"seed\": %llu,\n \"effects\": [",number,(unsigned long long)seed);
 for(size_t i=0;i<effs.size();i++){fprintf(k,"%s{\"id\": \"%s\", \"params\": {",i?", ":"",effs[i].id.c_str());for(size_t j=0;j<effs[i].p.size();j++)fprintf(k,"%s\"%s\": %.8g",j?", ":"",effs[i].p[j].first.c_str(),effs[i].p[j].second);fprintf(k,"}, \"units\": {");for(size_t j=0;j<effs[i].p.size();j++)fprintf(k,"%s\"%s\": \"%s\"",j?", ":"",effs[i].p[j].first.c_str(),unitof(effs[i].p[j].first));fprintf(k,"}}");}
 fprintf(k,"],\n \"mu_finger\": %.6g,\n \"mu_pusher\": %.6g,\n \"pad_tangential_n_m\": %.6g,\n \"pad_normal_n_m\": %.6g,\n \"pusher_n_m\": %.6g,\n \"pusher_tangential_n_m\": %.6g,\n \"pad_pressure\": \"%s\",\n \"pad_bristles\": \"%s\",\n \"pusher_bristles\": \"%s\",\n \"pad_difference_stiffness\": %.4g,\n \"pad_difference_friction\": %.4g,\n \"friction_scatter\": %.4g,\n \"grip_error\": %.4g,\n \"grip_scatter\": %.4g,\n \"jaw_mass_kg\": %.4g,\n \"jaw_lateral_n_m\": %.4g,\n \"grasp_offset_m\": %.4g,\n \"gap_m\": %.4g,\n \"clock_offset_s\": %.4g,\n \"plate_pitch_rad\": %.4g,\n \"plate_yaw_rad\": %.4g,\n \"line_rad\": %.4g,\n \"reference_grip_n\": %.6g,\n \"hold_before_s\": %.4g,\n \"rate_hz\": %g,\n \"mass_true_kg\": %.6g,\n \"time_step_s\": %g,\n \"trials\": %d,\n",muf,mup,ktp,knp,kps,kps*kratio,profs[prof],kinds[kind],kinds[kindp],dpk,dpm,scat,griperr,gripsd,jawm,klat,graspoff,gap,clock,sqp,sqy,sql,gref,hold,rate,mass,dt,(int)tr.size());
 fprintf(k," \"sensor_offsets\": [");for(int i=0;i<18;i++)fprintf(k,"%s%.5g",i?", ":"",off[i]);fprintf(k,"],\n \"pose_offsets\": [");for(int i=0;i<6;i++)fprintf(k,"%s%.5g",i?", ":"",poff[i]);fprintf(k,"],\n \"mu_of_trials\": [");for(size_t i=0;i<mus.size();i++)fprintf(k,"%s[%.5g, %.5g]",i?", ":"",mus[i][0],mus[i][1]);
 fprintf(k,"],\n \"conventions\": \"mu_finger is the mean of the fingers' sliding friction before effects; mu_of_trials [finger, pusher] has run-to-run scatter, wear and warming in it. pad_* and pusher_n_m are totals of one contact. viscosity_s_m: mu + viscosity * v (absolute). static: mu (1 + excess exp(-v/vs)). dwell: mu (1 + s ln(1 + age/cutoff)), age' = 1 - slip/renewal, hold_before_s is the age at t=0. load: mu (grip/reference_grip_n)^-exponent. anisotropic: mu sqrt(ratio) along object X, mu/sqrt(ratio) across. mismatch: finger1 mu(1+m), finger2 mu(1-m). adhesion: friction limit mu (N + pull_off) on each finger. face_tilt gradients over the patch position along object X from the geometric centre; grip gradient relative to trial's grip_n. waviness: 1 + A sin(2 pi x / wavelength + phase). plate_tilt: R_pusher Ry(pitch) Rz(yaw), beside plate_*_rad; line: R_pusher Rz(line_rad). gravity_tilt: Ry(about_y) Rx(about_x) g. external: (|F| - stiffness * displacement along F) F/|F| at at_x from the geometric centre. sensors: turned (R = exp(angles), wrench = R wrench), then crosstalk (signed normal: fy of a finger, world fx of the pusher), then gain, then offsets, bias and noise. mass_error: mass (1+fraction), inertia scaled; pose is of the geometric centre. clock_offset_s: object's pose is of t - clock_offset_s. grip_force_lag: cmd (1 - drop v^s/(v^s+knee^s) - drop_1_m * slip), first order with time_s; v of the patch with the turn at 2/3 radius.\"\n}\n");
 fclose(k);return 0;}
