// sim5: implicit simulator of a gripper bench. Elastic boundary-element pads (Boussinesq/Cerruti +
// thin layer), unilateral + Coulomb by active set / projected Gauss-Seidel with return mapping,
// rigid object (6 DOF) + arm (6 DOF) + jaw (1 DOF) solved together by backward Euler / Newton.
#include <cstdio>
#include <cstdlib>
#include <cmath>
#include <cstring>
#include <cstdint>
#include <string>
#include <vector>
#include <algorithm>
#include <sys/stat.h>
using namespace std;
typedef double D;
struct Rng{uint64_t s;Rng(uint64_t x=1):s(x*0x9E3779B97F4A7C15ull+12345){for(int i=0;i<4;i++)u64();}
 uint64_t u64(){uint64_t z=(s+=0x9E3779B97F4A7C15ull);z=(z^(z>>30))*0xBF58476D1CE4E5B9ull;z=(z^(z>>27))*0x94D049BB133111EBull;return z^(z>>31);}
 D u(){return (u64()>>11)*(1.0/9007199254740992.0);} D u(D a,D b){return a+(b-a)*u();}
 D lu(D a,D b){return a*pow(b/a,u());} D sg(){return u()<.5?-1:1;}
 D n(){D a=u()+1e-300,b=u();return sqrt(-2*log(a))*cos(2*M_PI*b);} int i(int n){return (int)(u()*n)%n;}};
struct V{D x,y,z;V(D a=0,D b=0,D c=0):x(a),y(b),z(c){}};
static inline V operator+(V a,V b){return V(a.x+b.x,a.y+b.y,a.z+b.z);} static inline V operator-(V a,V b){return V(a.x-b.x,a.y-b.y,a.z-b.z);}
static inline V operator*(D s,V a){return V(s*a.x,s*a.y,s*a.z);} static inline D dot(V a,V b){return a.x*b.x+a.y*b.y+a.z*b.z;}
static inline V cross(V a,V b){return V(a.y*b.z-a.z*b.y,a.z*b.x-a.x*b.z,a.x*b.y-a.y*b.x);} static inline D nrm(V a){return sqrt(dot(a,a));}
struct M3{D a[3][3];};
static M3 I3(){M3 m;memset(&m,0,sizeof m);m.a[0][0]=m.a[1][1]=m.a[2][2]=1;return m;}
static inline V mul(const M3&m,V v){return V(m.a[0][0]*v.x+m.a[0][1]*v.y+m.a[0][2]*v.z,m.a[1][0]*v.x+m.a[1][1]*v.y+m.a[1][2]*v.z,m.a[2][0]*v.x+m.a[2][1]*v.y+m.a[2][2]*v.z);}
static inline V mulT(const M3&m,V v){return V(m.a[0][0]*v.x+m.a[1][0]*v.y+m.a[2][0]*v.z,m.a[0][1]*v.x+m.a[1][1]*v.y+m.a[2][1]*v.z,m.a[0][2]*v.x+m.a[1][2]*v.y+m.a[2][2]*v.z);}
static M3 mm(const M3&p,const M3&q){M3 r;for(int i=0;i<3;i++)for(int j=0;j<3;j++){D s=0;for(int k=0;k<3;k++)s+=p.a[i][k]*q.a[k][j];r.a[i][j]=s;}return r;}
static M3 tr(const M3&p){M3 r;for(int i=0;i<3;i++)for(int j=0;j<3;j++)r.a[i][j]=p.a[j][i];return r;}
static M3 ex(V w){D t=nrm(w);M3 r=I3();D s,c;if(t<1e-9){s=1;c=.5;}else{s=sin(t)/t;D h=sin(t/2)/t;c=2*h*h;}
 D K[3][3]={{0,-w.z,w.y},{w.z,0,-w.x},{-w.y,w.x,0}};for(int i=0;i<3;i++)for(int j=0;j<3;j++){D k2=0;for(int k=0;k<3;k++)k2+=K[i][k]*K[k][j];r.a[i][j]+=s*K[i][j]+c*k2;}return r;}
static void quat(const M3&m,D*q){D t=m.a[0][0]+m.a[1][1]+m.a[2][2];if(t>0){D s=sqrt(t+1)*2;q[0]=s/4;q[1]=(m.a[2][1]-m.a[1][2])/s;q[2]=(m.a[0][2]-m.a[2][0])/s;q[3]=(m.a[1][0]-m.a[0][1])/s;}
 else if(m.a[0][0]>m.a[1][1]&&m.a[0][0]>m.a[2][2]){D s=sqrt(1+m.a[0][0]-m.a[1][1]-m.a[2][2])*2;q[0]=(m.a[2][1]-m.a[1][2])/s;q[1]=s/4;q[2]=(m.a[0][1]+m.a[1][0])/s;q[3]=(m.a[0][2]+m.a[2][0])/s;}
 else if(m.a[1][1]>m.a[2][2]){D s=sqrt(1+m.a[1][1]-m.a[0][0]-m.a[2][2])*2;q[0]=(m.a[0][2]-m.a[2][0])/s;q[1]=(m.a[0][1]+m.a[1][0])/s;q[2]=s/4;q[3]=(m.a[1][2]+m.a[2][1])/s;}
 else{D s=sqrt(1+m.a[2][2]-m.a[0][0]-m.a[1][1])*2;q[0]=(m.a[1][0]-m.a[0][1])/s;q[1]=(m.a[0][2]+m.a[2][0])/s;q[2]=(m.a[1][2]+m.a[2][1])/s;q[3]=s/4;}
 if(q[0]<0)for(int i=0;i<4;i++)q[i]=-q[i];}
static V qaxis(D x,D y,D z,D w){return V(x,y,z);}

const int N=48,N2=96; // nodes: rings of 3,9,15,21 with equal areas
static bool chol(D*A,int n,int ld){for(int j=0;j<n;j++){D s=A[j*ld+j];for(int k=0;k<j;k++)s-=A[j*ld+k]*A[j*ld+k];if(s<=0)return false;s=sqrt(s);A[j*ld+j]=s;
 for(int i=j+1;i<n;i++){D t=A[i*ld+j];const D*p=A+i*ld,*q=A+j*ld;D acc=0;for(int k=0;k<j;k++)acc+=p[k]*q[k];A[i*ld+j]=(t-acc)/s;}}return true;}
static void csolve(const D*A,int n,int ld,D*b){for(int i=0;i<n;i++){D s=b[i];for(int k=0;k<i;k++)s-=A[i*ld+k]*b[k];b[i]=s/A[i*ld+i];}
 for(int i=n-1;i>=0;i--){b[i]/=A[i*ld+i];for(int k=0;k<i;k++)b[k]-=A[i*ld+k]*b[i];}}

struct Eff{bool on(const char*id)const{for(auto&s:ids)if(s==id)return true;return false;}vector<string>ids;};
struct Par{ // everything about the set
 D L,side,mass,massT,comx,diam,aT; // told mass, true mass, true com; true pad radius
 D kn,ktr,beta,crownInv[2],tx[2],tz[2]; // pad
 D phi,tau; D mu,mup,dmu; V grav;
 D kj,fb,stict,mj,cj; D ka[3],kr[3],ma,ia,zeta;
 D kpl,kpt,kln,klt,wavA,wavL,wavP,plA,plL,plP,plZ; 
 V plOff,plRot,lnOff,lnRot; D plTiltP,plTiltY,lnTilt;
 D acc;bool jerk;D jt; D gx,gz; // grasp offset
 D gapP,gapL;
 // effects
 D sfx,svs,visc,lexp,an,mis,offx,offz,wedge,fgrad,closs,cloff,adh,wear,gain[3],lat;V ext;D extk,extx;
 D align;D thE0,thTau,thGap;D cabF,cabD;V cabAt;D uw;D play;
 // sensors
 D ff,fu,tf,tu,pf,pu,ptf,ptu,pn,rn,gpn,grn,lp,jit;V cam;D bias[18];D drift;int rezero;
 D sMu,sMuF,sMuP,sGrip,sPlace;
};
struct PadM{ D x[N],z[N]; D Cn[N][N]; D Ct[N2][N2]; D CtI[N2][N2]; };
static void inv(D*A,int n,int ld,D*out,int ldo){vector<D>b(n);vector<D>Q(n*n);for(int i=0;i<n;i++)for(int j=0;j<n;j++)Q[i*n+j]=A[i*ld+j];if(!chol(Q.data(),n,n)){fprintf(stderr,"chol fail\n");exit(1);}
 // inverse of L then product
 vector<D>Li(n*n,0.);for(int j=0;j<n;j++){Li[j*n+j]=1/Q[j*n+j];for(int i=j+1;i<n;i++){D s=0;for(int k=j;k<i;k++)s-=Q[i*n+k]*Li[k*n+j];Li[i*n+j]=s/Q[i*n+i];}}
 for(int i=0;i<n;i++)for(int j=0;j<n;j++)out[i*ldo+j]=0;
 for(int k=0;k<n;k++)for(int i=0;i<=k;i++){D a=Li[k*n+i];for(int j=0;j<=k;j++)out[i*ldo+j]+=a*Li[k*n+j];}}
static void buildPad(const Par&P,PadM&m){int k=0,cnt[4]={3,9,15,21};D a=P.aT;for(int r=0;r<4;r++){D ri=a*r/4.,ro=a*(r+1)/4.;D rc=2./3*(ro*ro*ro-ri*ri*ri)/(ro*ro-ri*ri);
  for(int j=0;j<cnt[r];j++){D t=2*M_PI*(j+0.5*(r%2)+0.17*r)/cnt[r];m.x[k]=rc*cos(t);m.z[k]=rc*sin(t);k++;}}
 D A=M_PI*a*a/N,b=sqrt(A/M_PI);
 auto norm=[&](D*C,int n,int ld,bool tg,D k){vector<D>I(n*n);inv(C,n,ld,I.data(),n);D s=0;for(int i=0;i<n;i++)for(int j=0;j<n;j++)if(!tg||(i<N&&j<N))s+=I[i*n+j];D f=s/k;for(int i=0;i<n;i++)for(int j=0;j<n;j++)C[i*ld+j]*=f;};
 static D H[N][N];for(int i=0;i<N;i++)for(int j=0;j<N;j++){D dx=m.x[i]-m.x[j],dz=m.z[i]-m.z[j],r2=dx*dx+dz*dz;H[i][j]=i==j?16/(3*M_PI*b):1/sqrt(r2+0.05*b*b);}
 norm(&H[0][0],N,N,false,1);
 for(int i=0;i<N;i++)for(int j=0;j<N;j++)m.Cn[i][j]=(P.beta*H[i][j]+(i==j?(1-P.beta)*N:0))/P.kn;
 norm(&m.Cn[0][0],N,N,false,P.kn);
 static D T[N2][N2];const D nu=.5;for(int i=0;i<N;i++)for(int j=0;j<N;j++){D dx=m.x[i]-m.x[j],dz=m.z[i]-m.z[j],r2=dx*dx+dz*dz+0.05*b*b,r=sqrt(r2);
  if(i==j){D v=16/(3*M_PI*b)*(1-nu/2);T[i][j]=T[N+i][N+j]=v;T[i][N+j]=T[N+i][j]=0;}
  else{T[i][j]=((1-nu)+nu*dx*dx/r2)/r;T[N+i][N+j]=((1-nu)+nu*dz*dz/r2)/r;T[i][N+j]=T[N+i][j]=nu*dx*dz/r2/r;}}
 norm(&T[0][0],N2,N2,true,1);
 for(int i=0;i<N2;i++)for(int j=0;j<N2;j++)m.Ct[i][j]=P.beta*T[i][j]+(i==j?(1-P.beta)*N:0);
 norm(&m.Ct[0][0],N2,N2,true,P.kn*P.ktr);
 inv(&m.Ct[0][0],N2,N2,&m.CtI[0][0],N2);}

struct Trial{int prim;D grip,speed,slope,off;int run;V pp;M3 pR;D qd[4];D ang,dist; // told pusher pose
 D mu1,mu2,mup,gripF;V place;int idx;D T0[2];};
struct Pad{ // state
 D s;D prof[N];D p[N],q[N2],u[N2],zn[N],zt[N2];D mu;
 bool act[N];D Kn[N][N];bool KnOk;bool wasC[N];
 D pen[N],dd[N2],yf[N];V on[N];D slipv[N];D lim[N];D sl[N2];V fn;
 V F,Mo;D Nn; // wrench on object, gripper frame, about gripper origin
 D K[7][7];D temp;D diss;};
struct Push{V m;D u1,u2,p,q1,q2;D wave;bool in;D s1,s2;};
struct Sim{
 const Par&P;const PadM&m;const Trial&T;D h;
 V com;M3 Ro;V v,w;V ga,gth,gav,gthv;D yj,yjv,c;Pad pad[2];vector<Push>ps;V Iin;
 D gs; // gravity scale
 M3 plR;V plP; V Fp,Mp; // pusher wrench about told origin
 V xcmd;M3 Rcmd;V xg;M3 Rg;V xr;M3 Rr;V xrn;M3 Rrn; D scC; long its=0,fails=0,steps=0,sweeps=0;D minclear=1;D maxres=0;
 V cab;V cabp;V fcab; bool usePusher=true;D gripF;
 D Win=0,Dfric=0,Ddamp=0,Wg=0; V armF,armM;
 Sim(const Par&P_,const PadM&m_,const Trial&T_,D h_):P(P_),m(m_),T(T_),h(h_){}
 void relpose(){Rr=mm(tr(Rg),Ro);V xo=com-mul(Ro,V(P.comx,0,0));xr=mulT(Rg,xo-xg);}
 D wave(D ox,D oz,D s){return P.wavA*sin(2*M_PI*ox/P.wavL+P.wavP+(s>0?0:1.7)+oz*60);}
 D faceY(const Pad&a,D x,D z,V*op){D s=a.s;V o0=mulT(Rr,V(x,0,z)-xr);D yy=s*P.side/2;D ox=o0.x+Rr.a[1][0]*yy,oz=o0.z+Rr.a[1][2]*yy;
  D wv=wave(ox,oz,s);D y=(s*(P.side/2+P.wedge*o0.x+wv)-o0.y)/(Rr.a[1][1]-s*P.wedge*Rr.a[1][0]);if(op)*op=V(o0.x+Rr.a[1][0]*y,o0.y+Rr.a[1][1]*y,o0.z+Rr.a[1][2]*y);return y;}
 D visA(){return P.phi>0?(h/P.tau)/(1+h/P.tau):0;} 
 void normal(Pad&a){D sc=1+P.phi*visA(),zf=P.phi>0?1/(1+h/P.tau):0;D rhs[N];for(int i=0;i<N;i++)rhs[i]=(a.pen[i]-zf*a.zn[i])/sc;
  D pa=P.adh/N;
  for(int it=0;it<30;it++){
   if(!a.KnOk){int id[N],n=0;for(int i=0;i<N;i++)if(a.act[i])id[n++]=i;memset(a.Kn,0,sizeof a.Kn);if(n){static D Q[N*N],O[N*N];for(int i=0;i<n;i++)for(int j=0;j<n;j++)Q[i*N+j]=m.Cn[id[i]][id[j]];inv(Q,n,N,O,N);for(int i=0;i<n;i++)for(int j=0;j<n;j++)a.Kn[id[i]][id[j]]=O[i*N+j];}a.KnOk=true;}
   D p[N];for(int i=0;i<N;i++)p[i]=0;for(int j=0;j<N;j++)if(a.act[j]){D r=rhs[j];for(int i=0;i<N;i++)p[i]+=a.Kn[j][i]*r;}
   bool ch=false;for(int i=0;i<N;i++){if(a.act[i]){if(p[i]<-(a.wasC[i]?pa:0)){a.act[i]=false;ch=true;}}else{D g=-rhs[i];for(int j=0;j<N;j++)g+=m.Cn[i][j]*p[j];if(g<-1e-12){a.act[i]=true;ch=true;}}}
   if(!ch||it==29){for(int i=0;i<N;i++)a.p[i]=max(p[i],-pa);break;}a.KnOk=false;}
 }
 void tang(Pad&a){D sc=1+P.phi*visA(),zf=P.phi>0?1/(1+h/P.tau):0;D e[N2];for(int i=0;i<N2;i++)e[i]=(a.u[i]+a.dd[i]-zf*a.zt[i])/sc; // target elastic displacement if stuck
  D pa=P.adh/N,An=M_PI*P.aT*P.aT/N,p0=25/(M_PI*pow(P.diam/2,2));
  D bv[N];for(int i=0;i<N;i++){D pc=a.act[i]?max(a.p[i]+pa,0.):0;D mu=a.mu;if(P.sfx>0)mu*=1+P.sfx*exp(-a.slipv[i]/P.svs);if(P.lexp!=0)mu*=pow(max(pc/An/p0,1e-3),-P.lexp);if(P.fgrad!=0)mu*=1+P.fgrad*a.on[i].x;if(P.thE0>0)mu*=1/(1+a.temp);
   a.lim[i]=mu*pc;bv[i]=P.visc>0?P.visc*pc/h*sc:0;}
  // residual
  D q[N2];memcpy(q,a.q,sizeof q);D r[N2];memcpy(r,e,sizeof r);for(int j=0;j<N2;j++){D qj=q[j];if(qj!=0)for(int i=0;i<N2;i++)r[i]-=m.Ct[j][i]*qj;}
  D ca=1,sa=0;bool an=P.an!=1;if(an){ca=Rr.a[0][0];sa=Rr.a[2][0];D n=hypot(ca,sa);ca/=n;sa/=n;}
  D kx=sqrt(P.an),kz=1/kx;
  D tolq=2e-6;int sw;for(sw=0;sw<80;sw++){D mx=0;for(int i=0;i<N;i++){D c=m.Ct[i][i];D tx=q[i]+r[i]/c,tz=q[N+i]+r[N+i]/c;D l=a.lim[i];D nx,nz;
    if(l<=0){nx=nz=0;}
    else if(!an){D t=hypot(tx,tz);if(t<=l){nx=tx;nz=tz;}else{D mg=l;if(bv[i]>0)mg=(l+bv[i]*c*t)/(1+bv[i]*c);nx=tx*mg/t;nz=tz*mg/t;}}
    else{D gx=ca*tx+sa*tz,gz=-sa*tx+ca*tz;D Lx=l*kx,Lz=l*kz;D f=gx*gx/(Lx*Lx)+gz*gz/(Lz*Lz);if(f>1){D lam=0;D A=Lx*Lx,B=Lz*Lz;for(int k=0;k<30;k++){D u1=gx*Lx/(A+lam),u2=gz*Lz/(B+lam);D g=u1*u1+u2*u2-1;D dg=-2*(u1*u1/(A+lam)+u2*u2/(B+lam));D st=-g/dg;lam+=st;if(fabs(st)<1e-10*(A+lam))break;}gx*=A/(A+lam);gz*=B/(B+lam);}nx=ca*gx-sa*gz;nz=sa*gx+ca*gz;}
    D dx=nx-q[i],dz=nz-q[N+i];D ch=max(fabs(dx),fabs(dz));if(ch>mx)mx=ch;if(ch>1e-8){const D*c1=m.Ct[i],*c2=m.Ct[N+i];for(int k=0;k<N2;k++)r[k]-=c1[k]*dx+c2[k]*dz;q[i]=nx;q[N+i]=nz;}}
   if(mx<tolq)break;}
  sweeps+=sw;
  memcpy(a.q,q,sizeof q);for(int i=0;i<N2;i++)a.sl[i]=r[i]*sc; // slip in this step
  for(int i=0;i<N;i++){D l=hypot(q[i],q[N+i]);if(!an&&l<a.lim[i]*(1-1e-9))a.sl[i]=a.sl[N+i]=0;}
 }
 void wrench(Pad&a){V F,M;a.Nn=0;V fn=a.fn;D sx=-fn.x/fn.y,sz=-fn.z/fn.y;for(int i=0;i<N;i++){V f(a.p[i]*fn.x-a.q[i],a.p[i]*fn.y-a.q[i]*sx-a.q[N+i]*sz,a.p[i]*fn.z-a.q[N+i]);V r(m.x[i]+P.offx,a.yf[i],m.z[i]+P.offz);F=F+f;M=M+cross(r,f);a.Nn+=a.p[i];}a.F=F;a.Mo=M;}
 void tangent(Pad&a){ // K: d(wrench, jawforce)/d(tau,rho,yj) sign: force decreases with displacement -> K positive = -dF/dX
  static D Bn[N][7],Bx[N2][7];V fn=a.fn;D sx=-fn.x/fn.y,sz=-fn.z/fn.y;V t1(1,sx,0),t3(0,sz,1);
  for(int i=0;i<N;i++){V r(m.x[i]+P.offx,a.yf[i],m.z[i]+P.offz);auto put=[&](D*b,V d){V c=cross(r,d);b[0]=d.x;b[1]=d.y;b[2]=d.z;b[3]=c.x;b[4]=c.y;b[5]=c.z;b[6]=0;};put(Bn[i],fn);Bn[i][6]=1;put(Bx[i],t1);put(Bx[N+i],t3);}
  // pen decreases by Bn.dX ; tang displacement increases by Bx.dX
  D sc=1+P.phi*visA();static D KB[N][7];for(int i=0;i<N;i++)for(int c=0;c<7;c++)KB[i][c]=0;for(int i=0;i<N;i++)if(a.act[i])for(int j=0;j<N;j++)if(a.act[j]){D k=a.Kn[i][j]/sc;for(int c=0;c<7;c++)KB[i][c]+=k*Bn[j][c];}
  memset(a.K,0,sizeof a.K);for(int i=0;i<N;i++)if(a.act[i])for(int c=0;c<7;c++)for(int d=0;d<7;d++)a.K[c][d]+=Bn[i][c]*KB[i][d];
  // tangential
  int n=0;static D dir[2*N][2];static int nd[2*N];static D Hi[2*N];
  for(int i=0;i<N;i++){if(a.lim[i]<=0)continue;D s=hypot(a.sl[i],a.sl[N+i]),g=hypot(a.q[i],a.q[N+i]);bool slip=s>1e-11&&g>=a.lim[i]*(1-1e-7);D W00=0,W01=0,W11=0;if(P.an!=1){D ca=Rr.a[0][0],sa=Rr.a[2][0],nn=hypot(ca,sa);ca/=nn;sa/=nn;D l2=a.lim[i]*a.lim[i],w1=1/(l2*P.an),w2=P.an/l2;W00=ca*ca*w1+sa*sa*w2;W11=sa*sa*w1+ca*ca*w2;W01=ca*sa*(w1-w2);D f=a.q[i]*(W00*a.q[i]+W01*a.q[N+i])+a.q[N+i]*(W01*a.q[i]+W11*a.q[N+i]);slip=s>1e-11&&f>=1-1e-6;}
   if(!slip){nd[n]=i;dir[n][0]=1;dir[n][1]=0;Hi[n++]=0;nd[n]=i;dir[n][0]=0;dir[n][1]=1;Hi[n++]=0;}
   else{D cx=a.sl[i]/s,cz=a.sl[N+i]/s;nd[n]=i;dir[n][0]=-cz;dir[n][1]=cx;Hi[n++]=P.an==1?s/sc/g:s/sc/hypot(W00*a.q[i]+W01*a.q[N+i],W01*a.q[i]+W11*a.q[N+i])*(cz*cz*W00-2*cx*cz*W01+cx*cx*W11);
    D pc=max(a.p[i]+P.adh/N,0.);if(P.visc>0){D b=P.visc*pc/h*sc;nd[n]=i;dir[n][0]=cx;dir[n][1]=cz;Hi[n++]=1/b;}
    // coupling -dq = mu t dp: force change = mu t (-KB dX)
    D mu=(P.an==1?a.lim[i]:g)/max(pc,1e-12);D tx=a.q[i]/g,tz=a.q[N+i]/g;if(a.act[i])for(int c=0;c<7;c++){D bb=Bx[i][c]*tx+Bx[N+i][c]*tz;if(bb!=0)for(int d=0;d<7;d++)a.K[c][d]-=mu*bb*KB[i][d];}}}
  if(n){static D A[N2*N2];static D B[7][N2],X[7][N2];for(int i=0;i<n;i++)for(int j=0;j<=i;j++){int p=nd[i],q=nd[j];A[i*N2+j]=dir[i][0]*(m.Ct[p][q]*dir[j][0]+m.Ct[p][N+q]*dir[j][1])+dir[i][1]*(m.Ct[N+p][q]*dir[j][0]+m.Ct[N+p][N+q]*dir[j][1]);if(i==j)A[i*N2+j]+=Hi[i];}
   bool ok=chol(A,n,N2);if(ok){for(int c=0;c<7;c++){for(int i=0;i<n;i++)B[c][i]=X[c][i]=dir[i][0]*Bx[nd[i]][c]+dir[i][1]*Bx[N+nd[i]][c];if(c<6)csolve(A,n,N2,X[c]);}
    for(int c=0;c<6;c++)for(int d=0;d<6;d++){D s=0;for(int i=0;i<n;i++)s+=B[c][i]*X[d][i];a.K[c][d]+=s/sc;}}}
 }
 // unknown vector X: object dx(3), dth(3), arm ga(3), gth(3), yj
 V com0;M3 Ro0;V ga0,gth0;D yj0;D c0;
 void setX(const D*X){com=com0+V(X[0],X[1],X[2]);Ro=mm(ex(V(X[3],X[4],X[5])),Ro0);ga=V(X[6],X[7],X[8]);gth=V(X[9],X[10],X[11]);yj=X[12];xg=xcmd+ga;Rg=mm(ex(gth),Rcmd);relpose();}
 D Jp[6][6];
 void pusher(bool tan){Fp=V();Mp=V();V Fo,Mc;if(tan)memset(Jp,0,sizeof Jp);if(!usePusher)return;V xo=com-mul(Ro,V(P.comx,0,0));bool line=T.prim==1;D kn=(line?P.kln:P.kpl)/ps.size(),kt=(line?P.klt:P.kpt)/ps.size();D mu=T.mup;
  V n,t1,t2;if(!line){n=V(plR.a[0][0],plR.a[1][0],plR.a[2][0]);t1=V(plR.a[0][1],plR.a[1][1],plR.a[2][1]);t2=V(plR.a[0][2],plR.a[1][2],plR.a[2][2]);}
  else{n=V(Ro.a[0][2],Ro.a[1][2],Ro.a[2][2]);t1=V(Ro.a[0][0],Ro.a[1][0],Ro.a[2][0]);t2=V(Ro.a[0][1],Ro.a[1][1],Ro.a[2][1]);}
  for(auto&k:ps){if(!k.in){k.p=k.q1=k.q2=0;continue;}V x,dp;D pen;V x0=com0-mul(Ro0,V(P.comx,0,0))+mul(Ro0,k.m);
   if(!line){x=xo+mul(Ro,k.m);dp=x-x0;pen=-dot(x-plP,n)-k.wave;}
   else{V xm=xo+mul(Ro,k.m);dp=xm-x0;x=x0; // node fixed in space: x0 = node position
     V o=mulT(Ro,x0-xo);pen=o.z+P.side/2-k.wave;}
   k.p=kn*pen;if(k.p<=0){k.p=k.q1=k.q2=0;k.s1=k.s2=0;continue;}
   D e1=k.u1+dot(dp,t1),e2=k.u2+dot(dp,t2);D a=-kt*e1,b=-kt*e2;D g=hypot(a,b),l=mu*k.p;bool sl=g>l;k.q1=sl?a*l/g:a;k.q2=sl?b*l/g:b;k.s1=e1+k.q1/kt;k.s2=e2+k.q2/kt;
   V f=k.p*n+k.q1*t1+k.q2*t2;V rc=x-com;Fo=Fo+f;Mc=Mc+cross(rc,f);Mp=Mp+cross(x-T.pp,f);
   if(tan){auto put=[&](D*bb,V d){V c=cross(rc,d);bb[0]=d.x;bb[1]=d.y;bb[2]=d.z;bb[3]=c.x;bb[4]=c.y;bb[5]=c.z;};D bn[6],b1[6],b2[6];put(bn,n);put(b1,t1);put(b2,t2);
    D k11=kt,k12=0,k22=kt;D m1=0,m2=0;if(sl){D c=a/g,s=b/g;D r=l/g*kt;k11=r*s*s;k22=r*c*c;k12=-r*c*s;m1=mu*c;m2=mu*s;}
    for(int i=0;i<6;i++)for(int j=0;j<6;j++)Jp[i][j]+=kn*bn[i]*bn[j]+b1[i]*(k11*b1[j]+k12*b2[j])+b2[i]*(k12*b1[j]+k22*b2[j])+(m1*b1[i]+m2*b2[i])*kn*bn[j];}}
  Fp=Fo;McP=Mc;}
 V McP;V fo[2],mo[2];
 D resid(const D*X,D*R){setX(X);V comn=com;
  for(int f=0;f<2;f++){Pad&a=pad[f];V fnO=V(P.wedge,-a.s,0);V g=mul(Rr,fnO);a.fn=(1/fabs(g.y))*g;
   for(int i=0;i<N;i++){a.yf[i]=faceY(a,m.x[i]+P.offx,m.z[i]+P.offz,0);a.pen[i]=a.s*a.yf[i]-(yj+a.prof[i]);V pn=mul(Rr,a.on[i])+xr;a.dd[i]=pn.x-(m.x[i]+P.offx);a.dd[N+i]=pn.z-(m.z[i]+P.offz);}
   normal(a);tang(a);wrench(a);}
  pusher(false);
  V Fo=Fp+gs*P.massT*P.grav+fext()+fcab,Mc=McP+gs*cross(mul(Ro,V(P.extx-P.comx,0,0)),fext())+cross(xcab()-com,fcab);V Fa,Ma;
  for(int f=0;f<2;f++){V F=mul(Rg,pad[f].F),M=mul(Rg,pad[f].Mo);Fo=Fo+F;Mc=Mc+M+cross(xg-com,F);Fa=Fa-F;Ma=Ma-M;}
  Fa=Fa-fcab;Ma=Ma-cross(xcab()-xg,fcab);
  V dv=(1/h)*((1/h)*(com-com0)-v);V wv=(1/h)*V(X[3],X[4],X[5]);V dw=mulT(Ro,(1/h)*(wv-w));V Iw=mul(Ro,V(Iin.x*dw.x,Iin.y*dw.y,Iin.z*dw.z));
  V r=P.massT*dv-Fo,q=Iw-Mc;R[0]=r.x;R[1]=r.y;R[2]=r.z;R[3]=q.x;R[4]=q.y;R[5]=q.z;
  D*gp[6]={&ga.x,&ga.y,&ga.z,&gth.x,&gth.y,&gth.z};D o[6]={ga0.x,ga0.y,ga0.z,gth0.x,gth0.y,gth0.z},ov[6]={gav.x,gav.y,gav.z,gthv.x,gthv.y,gthv.z},FF[6]={Fa.x,Fa.y,Fa.z,Ma.x,Ma.y,Ma.z};
  for(int i=0;i<6;i++){D k=i<3?P.ka[i]:P.kr[i-3],M=i<3?P.ma:P.ia;D cc=2*P.zeta*sqrt(k*M);D vel=(*gp[i]-o[i])/h;D e=*gp[i];if(i==4&&P.play>0){D cl=min(P.play,max(-P.play,e));e-=cl;}
   R[6+i]=M*(vel-ov[i])/h+cc*vel+k*e-FF[i];if(i==4&&P.play>0)R[6+i]+=0.05*vel;}
  {D vel=(yj-yj0)/h;R[12]=P.mj*(vel-yjv)/h+P.cj*vel+2*P.kj*(yj-c)-(pad[0].Nn+pad[1].Nn);}
  D s=0;for(int i=0;i<13;i++){D x=R[i];if((i>=3&&i<6)||(i>=9&&i<12))x/=0.02;s+=x*x;}return sqrt(s);}
 V fext(){return P.ext.x!=0||P.ext.y!=0||P.ext.z!=0?V(P.ext.x,P.ext.y,P.ext.z)+extadd:V();} V extadd;V xo_start;
 V xcab(){return com+mul(Ro,V(P.cabAt.x-P.comx,P.cabAt.y,P.cabAt.z));}
 void jac(D J[13][13]){memset(J,0,sizeof(D)*169);for(int i=0;i<3;i++)J[i][i]=P.massT/h/h;
  D Ii[3]={Iin.x,Iin.y,Iin.z};for(int i=0;i<3;i++)for(int j=0;j<3;j++)for(int k=0;k<3;k++)J[3+i][3+j]+=Ro.a[i][k]*Ii[k]*Ro.a[j][k]/h/h;
  for(int i=0;i<6;i++){D k=i<3?P.ka[i]:P.kr[i-3],M=i<3?P.ma:P.ia;D cc=2*P.zeta*sqrt(k*M);if(i==4&&P.play>0&&fabs(gth.y)<P.play){k=0;cc+=0.05;}J[6+i][6+i]=M/h/h+cc/h+k;}
  J[12][12]=P.mj/h/h+P.cj/h+2*P.kj;
  pusher(true);for(int i=0;i<6;i++)for(int j=0;j<6;j++)J[i][j]+=Jp[i][j];
  V d=xg-com;D A[7][13];memset(A,0,sizeof A);D S[3][3]={{0,d.z,-d.y},{-d.z,0,d.x},{d.y,-d.x,0}}; // (th x d) = S th
  for(int i=0;i<3;i++)for(int j=0;j<3;j++){A[i][j]=Rg.a[j][i];A[3+i][3+j]=Rg.a[j][i];A[i][6+j]=-Rg.a[j][i];A[3+i][9+j]=-Rg.a[j][i];D s=0;for(int k=0;k<3;k++)s+=Rg.a[k][i]*S[k][j];A[i][3+j]=s;}
  A[6][12]=1;
  D K[7][7];for(int i=0;i<7;i++)for(int j=0;j<7;j++)K[i][j]=pad[0].K[i][j]+pad[1].K[i][j];
  D KA[7][13];for(int i=0;i<7;i++)for(int j=0;j<13;j++){D s=0;for(int k=0;k<7;k++)s+=K[i][k]*A[k][j];KA[i][j]=s;}
  for(int i=0;i<13;i++)for(int j=0;j<13;j++){D s=0;for(int k=0;k<7;k++)s+=A[k][i]*KA[k][j];J[i][j]+=s;}}
 static bool lu(D J[13][13],D*b){int n=13;for(int c=0;c<n;c++){int p=c;for(int i=c+1;i<n;i++)if(fabs(J[i][c])>fabs(J[p][c]))p=i;if(J[p][c]==0)return false;if(p!=c){for(int j=0;j<n;j++)swap(J[p][j],J[c][j]);swap(b[p],b[c]);}
   for(int i=c+1;i<n;i++){D f=J[i][c]/J[c][c];if(f!=0){for(int j=c;j<n;j++)J[i][j]-=f*J[c][j];b[i]-=f*b[c];}}}
  for(int i=n-1;i>=0;i--){for(int j=i+1;j<n;j++)b[i]-=J[i][j]*b[j];b[i]/=J[i][i];}return true;}
 void stepBegin(){com0=com;Ro0=Ro;ga0=ga;gth0=gth;yj0=yj;V xo=com-mul(Ro,V(P.comx,0,0));
  for(int f=0;f<2;f++){Pad&a=pad[f];for(int i=0;i<N;i++){faceY(a,m.x[i]+P.offx,m.z[i]+P.offz,&a.on[i]);a.wasC[i]=a.act[i];}}
  if(T.prim==1){int k=0;D n=ps.size();for(auto&q:ps){D yy=(k-(n-1)/2)/n*P.side*1.15;k++;V x=plP+mul(plR,V(0,yy,0));V o=mulT(Ro,x-xo);bool in=fabs(o.y)<=P.side/2&&fabs(o.x)<P.L/2;q.m=o;if(!in){q.in=false;q.u1=q.u2=0;}else q.in=true;q.wave=P.plA*sin(2*M_PI*(o.x)/P.plL+P.plP+0.8*o.y/P.side);}}
  // explicit laws: external spring, cable
  extadd=V();if(P.extk!=0){V e=P.ext;D n=nrm(e);if(n>0){V dir=(1/n)*e;extadd=(-P.extk*dot(xo-xo_start,dir))*dir;}}
  if(P.cabF>0){V now=mulT(Rg,xcab()-xg);V d=now-cabp;cabp=now;V f=mulT(Rg,fcab);f=f-(P.cabF/P.cabD)*d;D n=nrm(f);if(n>P.cabF)f=(P.cabF/n)*f;fcab=mul(Rg,f);}
 }
 void step(V xc,M3 Rc,D fcmd){stepBegin();V dxc=xc-xcmd;M3 RcP=Rcmd;xcmd=xc;Rcmd=Rc;
  // servo of the jaw
  {D Fm=(pad[0].Nn+pad[1].Nn)/2;D err=fcmd-Fm;if(fabs(err)>P.stict*fcmd){D keff=1/(1/P.kj+1/P.kn);D wb=2*M_PI*P.fb;if(h>0.002)wb=min(wb,0.3/h);D dc=-h*wb*err/keff;c+=dc;}}
  D X0[13]={v.x*h,v.y*h,v.z*h,w.x*h,w.y*h,w.z*h,ga.x+h*gav.x,ga.y+h*gav.y,ga.z+h*gav.z,gth.x+h*gthv.x,gth.y+h*gthv.y,gth.z+h*gthv.z,yj+h*yjv};
  D XS[13]={0,0,0,0,0,0,ga.x,ga.y,ga.z,gth.x,gth.y,gth.z,yj};
  D X[13],R[13],best=1e9,bx[13],n=0;
  for(int at=0;at<4;at++){memcpy(X,at==1?XS:X0,sizeof X);if(at==3)memcpy(X,bx,sizeof X);n=resid(X,R);D damp=at==0?1:at==1?.7:at==2?.3:.1;int since=0;D loc=1e9,lx[13];
   for(int it=0;it<(at<2?40:120);it++){its++;if(n<loc){loc=n;memcpy(lx,X,sizeof X);since=0;}else since++;if(n<best){best=n;memcpy(bx,X,sizeof X);}if(n<3e-4)break;
    if(since>=3){damp=max(damp*0.6,0.02);since=0;if(n>5*loc){memcpy(X,lx,sizeof X);n=resid(X,R);}}
    tangent(pad[0]);tangent(pad[1]);D J[13][13];jac(J);D b[13];for(int i=0;i<13;i++)b[i]=-R[i];if(!lu(J,b))break;for(int i=0;i<13;i++)X[i]+=damp*b[i];n=resid(X,R);}
   if(n<best){best=n;memcpy(bx,X,sizeof X);}if(best<5e-3)break;}
  if(n>best){memcpy(X,bx,sizeof X);n=resid(X,R);}if(n>5e-3)fails++;if(n>maxres)maxres=n;steps++;
  // accept
  v=(1/h)*(com-com0);w=(1/h)*V(X[3],X[4],X[5]);gav=(1/h)*(ga-ga0);gthv=(1/h)*(gth-gth0);yjv=(yj-yj0)/h;
  D zf=1/(1+h/P.tau);
  for(int f=0;f<2;f++){Pad&a=pad[f];D us[N2];for(int i=0;i<N2;i++)us[i]=0;for(int j=0;j<N2;j++)for(int i=0;i<N2;i++)us[i]+=m.Ct[j][i]*a.q[j];D un[N];for(int i=0;i<N;i++)un[i]=0;for(int j=0;j<N;j++)for(int i=0;i<N;i++)un[i]+=m.Cn[j][i]*a.p[j];
   if(P.phi>0){for(int i=0;i<N;i++)a.zn[i]=zf*(a.zn[i]+h/P.tau*P.phi*un[i]);for(int i=0;i<N2;i++)a.zt[i]=zf*(a.zt[i]+h/P.tau*P.phi*us[i]);}
   D dis=0;for(int i=0;i<N;i++){a.slipv[i]+=(1-exp(-h/0.003))*(hypot(a.sl[i],a.sl[N+i])/h-a.slipv[i]);dis+=a.q[i]*a.sl[i]+a.q[N+i]*a.sl[N+i];}Dfric+=dis;
   if(P.thE0>0){a.temp+=dis/P.thE0;a.temp*=exp(-h/P.thTau);}
   for(int i=0;i<N2;i++)a.u[i]=us[i]+a.zt[i];
   for(int i=0;i<N;i++)if(!a.act[i]&&a.p[i]==0){/* free node: relaxed */}
  }
  D kt=(T.prim==1?P.klt:P.kpt)/max<size_t>(1,ps.size());for(auto&k:ps){if(k.p>0){Dfric+=-(k.q1*k.s1+k.q2*k.s2);k.u1=-k.q1/kt;k.u2=-k.q2/kt;}else k.u1=k.u2=0;}
  {V xo=com-mul(Ro,V(P.comx,0,0));V o=mulT(Ro,xg-xo);D cl=min(P.side/2-P.aT-max(fabs(o.z+P.offz),fabs(o.z)),P.L/2-P.aT-fabs(o.x)-fabs(P.offx));minclear=min(minclear,cl);}
  // energy bookkeeping: work of the base on the arm spring (translation)
  {V fs(P.ka[0]*ga.x,P.ka[1]*ga.y,P.ka[2]*ga.z);D e[3]={gav.x,gav.y,gav.z};D dd=0;for(int i=0;i<3;i++){D cc=2*P.zeta*sqrt(P.ka[i]*P.ma);D*q=i==0?&fs.x:i==1?&fs.y:&fs.z;*q+=cc*e[i];dd+=cc*e[i]*e[i]*h;}
   M3 dRc=mm(Rc,tr(RcP));V dth(.5*(dRc.a[2][1]-dRc.a[1][2]),.5*(dRc.a[0][2]-dRc.a[2][0]),.5*(dRc.a[1][0]-dRc.a[0][1]));D tq[3]={gth.x,gth.y,gth.z},tv[3]={gthv.x,gthv.y,gthv.z},td[3]={dth.x,dth.y,dth.z};for(int i=0;i<3;i++)Win-=(P.kr[i]*tq[i]+2*P.zeta*sqrt(P.kr[i]*P.ia)*tv[i])*td[i];Win+=-dot(fs,dxc);Ddamp+=dd;Wg+=gs*P.massT*dot(P.grav,com-com0);D e2[3]={gthv.x,gthv.y,gthv.z};for(int i=0;i<3;i++){D cc=2*P.zeta*sqrt(P.kr[i]*P.ia);Ddamp+=cc*e2[i]*e2[i]*h;}Ddamp+=P.cj*yjv*yjv*h;}
 }
 D elastic(){D E=0;for(int f=0;f<2;f++){Pad&a=pad[f];for(int i=0;i<N;i++)for(int j=0;j<N;j++)E+=.5*a.p[i]*m.Cn[i][j]*a.p[j];for(int i=0;i<N2;i++)for(int j=0;j<N2;j++)E+=.5*a.q[i]*m.Ct[i][j]*a.q[j];}
  D n=max<size_t>(1,ps.size());D kn=(T.prim==1?P.kln:P.kpl)/n,kt=(T.prim==1?P.klt:P.kpt)/n;for(auto&k:ps)E+=.5*k.p*k.p/kn+.5*(k.q1*k.q1+k.q2*k.q2)/kt;
  E+=.5*(P.ka[0]*ga.x*ga.x+P.ka[1]*ga.y*ga.y+P.ka[2]*ga.z*ga.z+P.kr[0]*gth.x*gth.x+P.kr[1]*gth.y*gth.y+P.kr[2]*gth.z*gth.z)+P.kj*(yj-c)*(yj-c);return E;}
 void init(){ps.clear();memset(pad,0,sizeof pad);com=V(-P.gx+T.place.x,T.place.y*0,-P.gz+T.place.z);Ro=ex(V(0,T.place.y,0));com=com+mul(Ro,V(P.comx,0,0));Rg=Rcmd=I3();xcmd=xg=V();v=w=ga=gth=gav=gthv=V();yjv=0;gs=0;fcab=V();
  D mass=P.massT,s=P.side,L=P.L;Iin=V(mass*s*s/6,mass*(s*s+L*L)/12,mass*(s*s+L*L)/12);
  D wr=P.uw*T.idx/59.;
  for(int f=0;f<2;f++){Pad&a=pad[f];a.s=f==0?1:-1;a.mu=f==0?T.mu1:T.mu2;a.temp=T.T0[f];for(int i=0;i<N;i++){a.act[i]=true;a.prof[i]=P.align*P.wedge*m.x[i]+.5*P.crownInv[f]*(m.x[i]*m.x[i]+m.z[i]*m.z[i])+P.tx[f]*m.x[i]+P.tz[f]*m.z[i]+wr*(f==0?1.:.3)*(f==0?m.x[i]:m.z[i])/P.aT;}a.KnOk=false;}
  yj=P.side/2-1.0*T.gripF/P.kn;c=yj-T.gripF/P.kj;yj0=yj;
  M3 tilt=ex(T.prim==0?P.plRot:P.lnRot);V off=T.prim==0?P.plOff:P.lnOff;if(T.prim==0)tilt=mm(mm(ex(V(0,0,P.plTiltY)),ex(V(0,P.plTiltP,0))),tilt);else tilt=mm(ex(V(0,0,0)),tilt);
  M3 pr=T.pR;if(T.prim==1&&P.lnTilt!=0){pr=mm(pr,ex(V(0,0,P.lnTilt)));} plR=mm(tilt,pr);plP=T.pp+off;
  if(T.prim==0){int g=6;for(int i=0;i<g;i++)for(int j=0;j<g;j++){Push k;memset(&k,0,sizeof k);D yy=((i+.5)/g-.5)*P.side,zz=((j+.5)/g-.5)*P.side;k.m=V(-P.L/2,yy,zz);k.wave=P.plA*sin(2*M_PI*yy/P.plL+P.plP)*cos(2*M_PI*zz/P.plZ+1);k.in=true;ps.push_back(k);}}
  else for(int i=0;i<11;i++){Push k;memset(&k,0,sizeof k);ps.push_back(k);}
  relpose();xo_start=com-mul(Ro,V(P.comx,0,0));cabp=mulT(Rg,xcab()-xg);
  // close jaw without weight (object supported), then let the weight come on
  D hh=h;h=0.004;gripF=T.gripF;for(int i=0;i<30;i++)step(V(),I3(),gripF);for(int i=0;i<25;i++){gs=(i+1)/25.;step(V(),I3(),gripF);}for(int i=0;i<25;i++)step(V(),I3(),gripF);h=hh;for(int i=0;i<(int)(0.02/h);i++)step(V(),I3(),gripF);
  Win=Dfric=Ddamp=Wg=0;its=steps=fails=sweeps=0;maxres=0;}
};
// path: distance travelled at time t after start
struct Path{D d,v,a,T;bool jerk;D jt;D trap(D t)const{D ta=v/a,vm=v;if(ta*v>d){vm=sqrt(a*d);ta=vm/a;}D tt=d/vm+ta;if(t<=0)return 0;if(t>=tt)return d;if(t<ta)return .5*a*t*t;if(t>tt-ta){D r=tt-t;return d-.5*a*r*r;}return .5*vm*ta+vm*(t-ta);}
 D at(D t)const{if(!jerk)return trap(t);D s=0;for(int i=0;i<16;i++)s+=trap(t-jt*(i+.5)/16);return s/16;}
 D total()const{D ta=v/a,vm=v;if(ta*v>d){vm=sqrt(a*d);ta=vm/a;}return d/vm+ta+(jerk?jt:0);}};
struct Rec{D t;V go;M3 gR;V xo;M3 Ro;D w[18];};
static void record(Sim&s,Rec&r,D t){const Par&P=s.P;r.t=t;r.go=s.xg;V gt=s.gth;if(P.play>0)gt.y-=min(P.play,max(-P.play,gt.y));r.gR=mm(ex(gt),s.Rcmd);r.xo=s.com-mul(s.Ro,V(P.comx,0,0));r.Ro=s.Ro;
 for(int f=0;f<2;f++){Pad&a=s.pad[f];V c(0,s.faceY(a,0,0,0),0);V M=a.Mo-cross(c,a.F);D*o=r.w+6*f;o[0]=a.F.x;o[1]=a.F.y;o[2]=a.F.z;o[3]=M.x;o[4]=M.y;o[5]=M.z;}
 r.w[12]=s.Fp.x;r.w[13]=s.Fp.y;r.w[14]=s.Fp.z;r.w[15]=s.Mp.x;r.w[16]=s.Mp.y;r.w[17]=s.Mp.z;}
static const D REST=0.3,AFTER=0.25;
static void runTrial(const Par&P,const PadM&m,const Trial&T,D h,vector<Rec>&out,Sim&s){s.init();Path pa;pa.jerk=P.jerk;pa.jt=P.jt;if(T.prim==0){pa.d=T.dist;pa.v=T.speed;pa.a=P.acc;}else{pa.d=T.ang;pa.v=T.speed;pa.a=P.acc*20;}
 D tend=REST+pa.total()+AFTER;int n=(int)ceil(tend/0.004)*(int)llround(0.004/h);out.clear();Rec r;record(s,r,0);out.push_back(r);
 for(int i=1;i<=n;i++){D t=i*h;D d=pa.at(t-REST);V xc;M3 Rc=I3();if(T.prim==0)xc=V(-cos(T.slope)*d,0,sin(T.slope)*d);else Rc=ex(V(0,-d,0));s.step(xc,Rc,s.gripF);record(s,r,t);out.push_back(r);}}

static string js;static void kv(const char*k,D v){char b[128];snprintf(b,128,"    \"%s\": %.7g,\n",k,v);js+=b;}
static void draw(Par&P,Rng&g,const Eff&E){memset((void*)&P,0,sizeof P);
 P.L=g.u(.08,.14);P.side=g.u(.020,.030);P.L=round(P.L*1e3)/1e3;P.side=round(P.side*2e3)/2e3;P.diam=round(g.u(.012,min(.020,P.side-.007))*1e3)/1e3;P.aT=P.diam/2;
 P.mu=g.u(.25,.8);P.mup=g.u(.1,.5);P.mass=round(g.lu(.1,.5)*1e4)/1e4;P.kn=g.lu(30e3,1500e3);P.ktr=g.u(.6,.9);P.beta=g.u(.1,.9);
 P.phi=g.u(0,.08);P.tau=g.lu(.01,.2);P.grav=V(0,0,-9.81);
 P.kj=g.lu(1e5,1e6);P.fb=g.lu(3,30);P.stict=g.u(.0005,.003);P.mj=.15;P.cj=2*.5*sqrt(P.mj*2*P.kj);D k=g.lu(2e5,5e6);for(int i=0;i<3;i++)P.ka[i]=k*g.u(.7,1.3);P.ka[1]*=.5;D lv=g.u(.05,.12);for(int i=0;i<3;i++)P.kr[i]=k*lv*lv*g.u(.7,1.3);P.ma=1.2;P.ia=1.2*.05*.05;P.zeta=g.u(.1,.4);
 P.kpl=g.lu(1e5,5e6);P.kpt=P.kpl*g.u(.6,.9);P.kln=g.lu(1e5,5e6);P.klt=P.kln*g.u(.6,.9);P.wavA=g.u(.2e-6,1.5e-6);P.wavL=g.u(.015,.06);P.wavP=g.u(0,6.28);P.plA=g.u(.2e-6,1.5e-6);P.plL=g.u(.01,.03);P.plZ=g.u(.01,.03);P.plP=g.u(0,6.28);
 auto ov=[&](D a,D b){return V(g.sg()*g.u(a,b),g.sg()*g.u(a,b),g.sg()*g.u(a,b));};P.plOff=ov(10e-6,40e-6);P.plRot=ov(.05e-3,.3e-3);P.lnOff=ov(10e-6,40e-6);P.lnRot=ov(.05e-3,.3e-3);
 P.acc=g.lu(.2,1.2);P.jerk=g.u()<.5;P.jt=g.u(.02,.08);P.gx=g.u(-.003,.003);P.gz=g.u(-.0003,.0003);P.gapP=g.u(.2e-3,.5e-3);P.gapL=g.u(.1e-3,.3e-3);P.an=1;
 auto r2=[&](D a,D b,int d){D s=pow(10,d);return round(g.u(a,b)*s)/s;};
 P.ff=r2(.01,.04,3);P.fu=r2(.1,.3,2);P.tf=r2(.0002,.0006,5);P.tu=r2(.002,.004,4);P.pf=r2(.03,.06,3);P.pu=r2(.3,.75,2);P.ptf=r2(.001,.003,4);P.ptu=r2(.015,.037,3);P.pn=r2(2e-5,5e-5,6);P.rn=r2(2e-4,4e-4,5);P.gpn=g.u(2e-6,8e-6);P.grn=g.u(1e-5,4e-5);P.lp=g.u(.5e-3,2e-3);P.jit=1e-3;P.cam=V(g.u(-1,1)*.3e-3/1.8,g.u(-1,1)*.3e-3/1.8,g.u(-1,1)*.3e-3/1.8);
 for(int i=0;i<18;i++){D u=i<12?(i%6<3?P.fu:P.tu):(i<15?P.pu:P.ptu);P.bias[i]=g.u(-.6,.6)*u;}P.drift=g.u(.002,.01);P.rezero=5+g.i(11);
 P.sMu=g.u(.01,.05);P.sMuF=g.u(.002,.01);P.sMuP=g.u(.01,.04);P.sGrip=g.u(.001,.004);P.sPlace=g.u(30e-6,80e-6);P.dmu=g.u(-.006,.006);
 P.massT=P.mass;
 auto S=[&](){return g.u(.75,1.5);};
 if(E.on("static_friction")){P.sfx=.2*S();P.svs=.002*S();}
 if(E.on("viscous_friction"))P.visc=2*S();
 if(E.on("load_dependent_friction"))P.lexp=.15*S();
 if(E.on("anisotropic_friction"))P.an=exp(g.sg()*log(1.4)*S());
 if(E.on("finger_friction_mismatch"))P.mis=g.sg()*.15*S();
 if(E.on("torsional_friction")){D d=.002*S();if(P.diam>=.0145||P.side-P.diam<.010)d=-d;P.aT=P.diam/2+d;}
 if(E.on("pressure_offset")){P.offx=g.sg()*.002*S();P.offz=g.sg()*.001*S();}
 if(E.on("face_tilt")){if(g.u()<.6)P.wedge=g.sg()*.01*S();else P.fgrad=g.sg()*6*S();}
 if(E.on("plate_tilt")){P.plTiltP=g.sg()*.01*S();P.plTiltY=g.sg()*.01*S();P.lnTilt=g.sg()*.01*S();}
 if(E.on("mass_error")){P.massT=P.mass*(1+g.sg()*.1*S());P.comx=g.sg()*.004*S();}
 if(E.on("grip_force_loss")){if(g.u()<.6)P.closs=.1*S();else P.cloff=1*S();}
 if(E.on("adhesion"))P.adh=1*S();
 if(E.on("wear_drift")){P.wear=-.0006*g.u(1.1,1.7);P.sMu=g.u(.01,.02);}
 if(E.on("sensor_gain"))P.gain[g.i(3)]=g.sg()*.05*S();
 if(E.on("gravity_tilt")){D a=g.sg()*.05*S(),b=g.sg()*.05*S();P.grav=mul(mm(ex(V(a,0,0)),ex(V(0,b,0))),V(0,0,-9.81));kv("gravity_about_x_rad",a);kv("gravity_about_y_rad",b);}
 if(E.on("mocap_latency"))P.lat=.02*S();
 if(E.on("external_force")){P.ext=V(g.sg()*.5*S(),g.sg()*.5*S(),g.sg()*.5*S());P.extk=g.u(0,25);P.extx=g.u(-.02,.02);}
 if(E.on("x_temperature")){P.thE0=g.u(.25,.5);P.thTau=g.u(2,6);P.thGap=g.u(4,10);}
 if(E.on("x_cable")){P.cabF=g.u(.8,1.6);P.cabD=g.u(.4e-3,1e-3);P.cabAt=V(g.u(-.02,.03),0,P.side/2);}
 if(E.on("x_uneven_wear"))P.uw=g.u(.8,1.2)*22/P.kn;
 if(E.on("x_play"))P.play=g.u(.003,.006);
 if(E.on("check")){P.phi=0;P.wavA=P.plA=0;P.plOff=P.plRot=P.lnOff=P.lnRot=V();P.gx=P.gz=0;P.sMu=P.sMuF=P.sMuP=P.sGrip=P.sPlace=P.dmu=0;}
}
static void num(const char*k,const D*v,int n){js+=string("    \"")+k+"\": [";char b[40];for(int i=0;i<n;i++){snprintf(b,40,"%s%.7g",i?", ":"",v[i]);js+=b;}js+="],\n";}
int main(int ac,char**av){if(ac<6){fprintf(stderr,"sim5 NUM SEED EFFECTS|none SETDIR KEY [h] [maxtrials]\n");return 1;}
 int num_=atoi(av[1]);uint64_t seed=strtoull(av[2],0,10);Eff E;{string s=av[3],c;for(char ch:s+","){if(ch==','){if(c.size()&&c!="none")E.ids.push_back(c);c="";}else c+=ch;}}
 string dir=av[4];D h=ac>6?atof(av[6]):1e-3;int maxT=ac>7?atoi(av[7]):1000;bool check=E.on("check");
 Rng g(seed);Par P;draw(P,g,E);
 // grips that hold the weight
 if(P.mass*9.81>.45*2*P.mu*14){P.mass=round(.45*2*P.mu*14/9.81*1e4)/1e4;P.massT=P.massT*0+P.mass*(E.on("mass_error")?1.:1.);if(E.on("mass_error"))P.massT=P.mass*(1+(P.comx>0?.1:-.1)*1.1);}
 D gmin=max(10.,P.mass*9.81/(.35*2*P.mu));gmin=min(max(gmin,10.),18.);gmin=round(gmin);D gs3[3]={gmin,round(g.u(gmin+5,27)),round(g.u(30,40))};
 D d0=gmin/P.kn;{D lim=2*1.0*d0/(P.aT*P.aT);for(int f=0;f<2;f++)P.crownInv[f]=g.u(0,min(1/.15,lim));D a=g.u(0,2e-3);for(int f=0;f<2;f++){D t=min(g.u(.3,1.)*a,.35*d0/P.aT),an=g.u(0,6.28);P.tx[f]=t*cos(an);P.tz[f]=t*sin(an);}}
 if(P.wedge!=0)P.align=1-min(1.,.35*d0/P.aT/fabs(P.wedge));
 if(check){P.beta=.0;P.crownInv[0]=P.crownInv[1]=0;P.tx[0]=P.tx[1]=P.tz[0]=P.tz[1]=0;}
 D sp2[2]={round(g.u(.005,.014)*1e3)/1e3,round(g.u(.022,.045)*1e3)/1e3};D smax=g.u(.12,.35);smax=round(smax*180/M_PI)*M_PI/180;D sl3[3]={-smax,0,smax};if(check){sl3[0]=sl3[2]=0;}
 D marg=(P.side-P.diam)/2-max(0.,P.aT-P.diam/2)-fabs(P.offz)-.8e-3;D wr=P.mass*9.81/(2*P.mu*gmin);D dmax=min(.012,marg/(min(tan(smax),P.mup+.1)+1.1*wr+.03));
 D pre=P.mu*40/(P.kn*P.ktr);dmax=max(dmax,.0035+pre+P.gapP);
 D ra2[2]={round(g.u(.05,.12)*1e3)/1e3,round(g.u(.2,.4)*1e3)/1e3};D offs[2]={0,round(g.u(.008,.4*P.L/2)*1e3)/1e3};
 PadM*m=new PadM;buildPad(P,*m);
 vector<Trial>ts;D pivx=-(P.L/2-.005);
 D lever=-pivx-offs[1]; D wind=.667*P.mu*40*P.aT/(P.kn*P.ktr*P.aT*P.aT*.5);
 for(int gi=0;gi<3;gi++)for(int si=0;si<2;si++)for(int k=0;k<3;k++)for(int r=0;r<2;r++){Trial t;memset((void*)&t,0,sizeof t);t.prim=0;t.grip=gs3[gi];t.speed=sp2[si];t.slope=sl3[k];t.run=r;t.dist=min(dmax,max(.0045+pre,sp2[si]*.7));t.pp=V(-P.L/2-P.gapP-P.gx,0,0);t.pR=I3();D q[4]={1,0,0,0};memcpy(t.qd,q,sizeof q);ts.push_back(t);}
 for(int gi=0;gi<3;gi++)for(int si=0;si<2;si++)for(int k=0;k<2;k++)for(int r=0;r<2;r++){Trial t;memset((void*)&t,0,sizeof t);t.prim=1;t.grip=gs3[gi];t.speed=ra2[si];t.off=offs[k];t.run=r;D lv=-pivx-offs[k];t.ang=P.gapL/lv+.06+1.5*wind+.5*ra2[si]*.6;t.pp=V(pivx+offs[k]-P.gx,0,-P.side/2-P.gapL-P.gz);M3 R=ex(V(0,-M_PI/2,0));t.pR=R;D q[4]={sqrt(.5),0,-sqrt(.5),0};memcpy(t.qd,q,sizeof q);
  for(int c=0;c<3;c++){D*pp=c==0?&t.pp.x:c==1?&t.pp.y:&t.pp.z;*pp=round(*pp*1e6)/1e6;}ts.push_back(t);}
 for(auto&t:ts){t.pp.x=round(t.pp.x*1e6)/1e6;t.pp.z=round(t.pp.z*1e6)/1e6;}
 // order: shuffled, or all first runs then all second runs shuffled
 bool byrun=g.u()<.5;for(int i=(int)ts.size()-1;i>0;i--)swap(ts[i],ts[g.i(i+1)]);if(byrun)stable_sort(ts.begin(),ts.end(),[](const Trial&a,const Trial&b){return a.run<b.run;});
 if(check)stable_sort(ts.begin(),ts.end(),[](const Trial&a,const Trial&b){return a.prim*100+a.grip+a.run*1000<b.prim*100+b.grip+b.run*1000;});
 mkdir(dir.c_str(),0755);mkdir((dir+"/trials").c_str(),0755);FILE*fc=fopen((dir+"/trials.csv").c_str(),"w");fprintf(fc,"trial,file,object,primitive,grip_n,speed_m_s,speed_rad_s,slope_rad,pusher_offset_m,run,pusher_x_m,pusher_y_m,pusher_z_m,pusher_qw,pusher_qx,pusher_qy,pusher_qz\n");
 {FILE*f=fopen((dir+"/dataset.toml").c_str(),"w");fprintf(f,"format = \"stickslip-dataset/1\"\nname = \"bench5-%d\"\nsample_rate_hz = 250.0\ngravity_m_s2 = [0.0, 0.0, -9.81]\n\n[[objects]]\nid = \"bar\"\nshape = \"prism\"\nlength_m = %g\nside_m = %g\nmass_kg = %g\n\n[fingers]\ncontact = \"disc\"\ndiameter_m = %g\n\n[pushers.linear_push]\ncontact = \"plane\"\n\n[pushers.pivot]\ncontact = \"line\"\nlength_m = %g\n\n[sensors.finger]\nforce_noise_n = %g\nforce_uncertainty_n = %g\ntorque_noise_nm = %g\ntorque_uncertainty_nm = %g\n\n[sensors.pusher]\nforce_noise_n = %g\nforce_uncertainty_n = %g\ntorque_noise_nm = %g\ntorque_uncertainty_nm = %g\n\n[sensors.pose]\nposition_noise_m = %g\nrotation_noise_rad = %g\n",num_,P.L,P.side,P.mass,P.diam,round(P.side*1.15*1e3)/1e3,P.ff,P.fu,P.tf,P.tu,P.pf,P.pu,P.ptf,P.ptu,P.pn,P.rn);fclose(f);}
 D wk[18]={0};D Tt[2]={0,0};long its=0,steps=0,fails=0,sw=0;D minc=1,mres=0;string tj="  \"trials\": [\n";
 for(size_t n=0;n<ts.size()&&(int)n<maxT;n++){Trial&t=ts[n];t.idx=(int)n;D cm=(1+P.sMu*g.n())*(1+P.wear*n);t.mu1=P.mu*cm*(1+P.dmu+P.mis+P.sMuF*g.n());t.mu2=P.mu*cm*(1-P.dmu-P.mis+P.sMuF*g.n());t.mup=P.mup*(1+P.sMuP*g.n());t.gripF=(t.grip*(1-P.closs)-P.cloff)*(1+P.sGrip*g.n());t.place=V(P.sPlace*g.n(),2e-4*g.n(),P.sPlace*g.n()*.5);if(check)t.place=V();
  for(int f=0;f<2;f++)t.T0[f]=Tt[f];
  Sim*s=new Sim(P,*m,t,h);vector<Rec>R;runTrial(P,*m,t,h,R,*s);if(P.thE0>0)for(int f=0;f<2;f++)Tt[f]=s->pad[f].temp*exp(-P.thGap/P.thTau);
  its+=s->its;steps+=s->steps;fails+=s->fails;sw+=s->sweeps;minc=min(minc,s->minclear);mres=max(mres,s->maxres);
  if(check){ // figures
   D KE=.5*P.massT*dot(s->v,s->v);static D E0;(void)KE;Rec&e=R[R.size()-1-(size_t)((AFTER+.08)/h)];D Nn=(-e.w[1]+e.w[7])/2;
   D Tq=0,Tq2=0;for(int f=0;f<2;f++)for(int i=0;i<N;i++){Tq+=s->pad[f].mu*s->pad[f].p[i]*hypot(m->x[i],m->z[i]);}(void)Tq2;
   Sim*s0=new Sim(P,*m,t,h);s0->init();E0=s0->elastic();delete s0;
   printf("%s grip %.0f speed %.3f: N %.4f pusher F %.4f (2muN=%.4f) | torque y fingers %.5f (int mu p r=%.5f; 4/3 mu N a=%.5f) | energy: Win %.6f Wg %.6f dEel %.6f Dfric %.6f Ddamp %.6f rest %.6f\n",t.prim?"pivot":"push",t.grip,t.speed,Nn,e.w[12],(t.mu1+t.mu2)*Nn,e.w[4]+e.w[10],Tq,2*2./3*.5*(t.mu1+t.mu2)*Nn*P.aT,s->Win,s->Wg,s->elastic()-E0,s->Dfric,s->Ddamp,s->Win+s->Wg-(s->elastic()-E0)-s->Dfric-s->Ddamp);}
  char fn[64];snprintf(fn,64,"trials/t%04d.csv",(int)n);
  fprintf(fc,"t%04d,%s,bar,%s,%g,",(int)n,fn,t.prim?"pivot":"linear_push",t.grip);if(t.prim)fprintf(fc,",%g,,%g,",t.speed,t.off);else fprintf(fc,"%g,,%.6g,,",t.speed,t.slope);fprintf(fc,"%d,%.6g,%.6g,%.6g,%.9g,%.9g,%.9g,%.9g\n",t.run,t.pp.x,t.pp.y,t.pp.z,t.qd[0],t.qd[1],t.qd[2],t.qd[3]);
  // sensors
  if(n%P.rezero==0)memset(wk,0,sizeof wk);D slope_[18];for(int i=0;i<18;i++){D u=i<12?(i%6<3?P.fu:P.tu):(i<15?P.pu:P.ptu);wk[i]+=P.drift*u*g.n();slope_[i]=P.drift*u*g.n()*.5;}
  FILE*f=fopen((dir+"/"+fn).c_str(),"w");fprintf(f,"t_s,grip_cmd_n,gripper_x_m,gripper_y_m,gripper_z_m,gripper_qw,gripper_qx,gripper_qy,gripper_qz,object_x_m,object_y_m,object_z_m,object_qw,object_qx,object_qy,object_qz,finger1_fx_n,finger1_fy_n,finger1_fz_n,finger1_tx_nm,finger1_ty_nm,finger1_tz_nm,finger2_fx_n,finger2_fy_n,finger2_fz_n,finger2_tx_nm,finger2_ty_nm,finger2_tz_nm,pusher_fx_n,pusher_fy_n,pusher_fz_n,pusher_tx_nm,pusher_ty_nm,pusher_tz_nm\n");
  bool clean=check||E.on("clean");D st[18];memcpy(st,R[0].w,sizeof st);D al=1-exp(-h/P.lp);int every=(int)llround(.004/h);M3 Rc=ex(P.cam);
  for(size_t i=0;i<R.size();i++){for(int c=0;c<18;c++)st[c]+=al*(R[i].w[c]-st[c]);if(i%every)continue;Rec&r=R[i];D jt=clean?0:g.u()*P.jit;D td=r.t-P.lat-jt;D x=td/h;if(x<0)x=0;size_t k=min((size_t)x,R.size()-2);D fr=min(x-k,1.);V xo=R[k].xo+fr*(R[k+1].xo-R[k].xo);M3 Ro=fr<.5?R[k].Ro:R[k+1].Ro;{M3 dR=mm(R[k+1].Ro,tr(R[k].Ro));V wv(.5*(dR.a[2][1]-dR.a[1][2]),.5*(dR.a[0][2]-dR.a[2][0]),.5*(dR.a[1][0]-dR.a[0][1]));Ro=mm(ex(fr*wv),R[k].Ro);}
   V go=r.go;M3 gR=r.gR;if(!clean){xo=mul(Rc,xo)+P.pn*V(g.n(),g.n(),g.n());Ro=mm(mm(ex(P.rn*V(g.n(),g.n(),g.n())),Rc),Ro);go=go+P.gpn*V(g.n(),g.n(),g.n());gR=mm(ex(P.grn*V(g.n(),g.n(),g.n())),gR);}
   D q1[4],q2[4];quat(gR,q1);quat(Ro,q2);fprintf(f,"%.6g,%g,%.7g,%.7g,%.7g,%.9g,%.9g,%.9g,%.9g,%.7g,%.7g,%.7g,%.9g,%.9g,%.9g,%.9g",r.t,t.grip,go.x,go.y,go.z,q1[0],q1[1],q1[2],q1[3],xo.x,xo.y,xo.z,q2[0],q2[1],q2[2],q2[3]);
   for(int c=0;c<18;c++){D y=st[c];if(!clean){y*=1+P.gain[c/6];D nz=c<12?(c%6<3?P.ff:P.tf):(c<15?P.pf:P.ptf);y+=P.bias[c]+wk[c]+slope_[c]*r.t+nz*g.n();}else y=r.w[c];fprintf(f,",%.7g",y);}fprintf(f,"\n");}
  fclose(f);char b[200];snprintf(b,200,"    {\"trial\": \"t%04d\", \"mu1\": %.5f, \"mu2\": %.5f, \"mu_pusher\": %.5f, \"grip_true_n\": %.4f}%s\n",(int)n,t.mu1,t.mu2,t.mup,t.gripF,(n+1<ts.size()&&(int)n+1<maxT)?",":"");tj+=b;delete s;}
 fclose(fc);tj+="  ]\n";
 FILE*fk=fopen(av[5],"w");string ids;for(auto&s:E.ids)ids+=(ids.size()?", \"":"\"")+s+"\"";
 string ex=js;js="";
 kv("length_m",P.L);kv("side_m",P.side);kv("mass_told_kg",P.mass);kv("mass_true_kg",P.massT);kv("com_x_true_m",P.comx);kv("disc_diameter_told_m",P.diam);kv("pad_radius_true_m",P.aT);kv("mu_finger",P.mu);kv("mu_pusher",P.mup);kv("finger_mu_nuisance_halfdiff",P.dmu);
 kv("pad_kn_n_m",P.kn);kv("pad_shear_ratio",P.ktr);kv("pad_halfspace_blend",P.beta);num("pad_crown_1_m",P.crownInv,2);num("pad_tilt_x_rad",P.tx,2);num("pad_tilt_z_rad",P.tz,2);kv("pad_creep",P.phi);kv("pad_creep_s",P.tau);
 kv("jaw_stiffness_n_m",P.kj);kv("jaw_bandwidth_hz",P.fb);kv("jaw_stiction_rel",P.stict);num("arm_stiffness_n_m",P.ka,3);num("arm_rot_stiffness_nm_rad",P.kr,3);kv("arm_damping_ratio",P.zeta);
 kv("plate_kn_n_m",P.kpl);kv("plate_kt_n_m",P.kpt);kv("edge_kn_n_m",P.kln);kv("edge_kt_n_m",P.klt);kv("face_wave_m",P.wavA);kv("face_wave_length_m",P.wavL);kv("plate_wave_m",P.plA);
 D a3[3]={P.plOff.x,P.plOff.y,P.plOff.z};num("plate_offset_m",a3,3);D b3[3]={P.plRot.x,P.plRot.y,P.plRot.z};num("plate_rot_rad",b3,3);D c3[3]={P.lnOff.x,P.lnOff.y,P.lnOff.z};num("edge_offset_m",c3,3);D d3[3]={P.lnRot.x,P.lnRot.y,P.lnRot.z};num("edge_rot_rad",d3,3);
 kv("path_acc_m_s2",P.acc);kv("path_jerk_limited",P.jerk);kv("path_jerk_s",P.jt);kv("grasp_x_m",P.gx);kv("grasp_z_m",P.gz);D e3[3]={P.cam.x,P.cam.y,P.cam.z};num("camera_rot_rad",e3,3);num("sensor_bias",P.bias,18);kv("sensor_lowpass_s",P.lp);kv("sensor_drift_rel",P.drift);kv("rezero_every",P.rezero);kv("spread_mu_common",P.sMu);kv("spread_mu_finger",P.sMuF);kv("spread_mu_pusher",P.sMuP);kv("spread_grip",P.sGrip);kv("order_by_run",byrun);
 js+="    \"_\": 0\n";string all=js;js=ex;
 kv("static_friction.excess",P.sfx);kv("static_friction.stribeck_speed_m_s",P.svs);kv("viscous_friction.viscosity_s_m",P.visc);kv("load_dependent_friction.exponent",P.lexp);kv("anisotropic_friction.ratio",P.an);kv("finger_friction_mismatch.mismatch",P.mis);kv("torsional_friction.radius_change_m",P.aT-P.diam/2);kv("pressure_offset.offset_x_m",P.offx);kv("pressure_offset.offset_z_m",P.offz);kv("face_tilt.slope_rad",P.wedge);kv("face_tilt.friction_gradient_1_m",P.fgrad);kv("plate_tilt.pitch_rad",P.plTiltP);kv("plate_tilt.yaw_rad",P.plTiltY);kv("plate_tilt.line_rad",P.lnTilt);kv("mass_error.fraction",P.massT/P.mass-1);kv("mass_error.com_x_m",P.comx);kv("grip_force_loss.fraction",P.closs);kv("grip_force_loss.offset_n",P.cloff);kv("adhesion.pull_off_n",P.adh);kv("wear_drift.rate_per_trial",P.wear);kv("sensor_gain.finger1",P.gain[0]);kv("sensor_gain.finger2",P.gain[1]);kv("sensor_gain.pusher",P.gain[2]);kv("mocap_latency.latency_s",P.lat);kv("external_force.x_n",P.ext.x);kv("external_force.y_n",P.ext.y);kv("external_force.z_n",P.ext.z);kv("external_force.stiffness_n_m",P.extk);kv("external_force.at_x_m",P.extx);
 kv("face_tilt.pads_aligned_share",P.align);kv("x_temperature.E0_j",P.thE0);kv("x_temperature.tau_s",P.thTau);kv("x_temperature.pause_s",P.thGap);kv("x_cable.force_n",P.cabF);kv("x_cable.length_m",P.cabD);kv("x_uneven_wear.final_edge_m",P.uw);kv("x_play.half_rad",P.play);js+="    \"_\": 0\n";
 fprintf(fk,"{\n  \"set\": %d, \"seed\": %llu, \"effects\": [%s],\n  \"strengths\": {\n%s  },\n  \"drawn\": {\n%s  },\n  \"numerics\": {\"steps\": %ld, \"newton_iterations\": %ld, \"steps_above_5e-3N\": %ld, \"max_residual_n\": %.4g, \"min_pad_clearance_m\": %.5g},\n%s}\n",num_,(unsigned long long)seed,ids.c_str(),js.c_str(),all.c_str(),steps,its,fails,mres,minc,tj.c_str());fclose(fk);
 printf("set %d: steps %ld newton/step %.2f sweeps/newton/pad %.1f fails %ld maxres %.3g minclear %.5f\n",num_,steps,(D)its/steps,(D)sw/2./max(1L,its),fails,mres,minc);return 0;}
