// Independent 3-D bench: rigid prism between two bristle pads on a force-controlled jaw, pushed on a plate or an edge.
// Explicit (semi-implicit Euler) penalty dynamics; the equations are those of the code.
#pragma once
#include <cmath>
#include <cstdio>
#include <vector>
#include <string>
#include <array>
#include <algorithm>
#include <random>
struct V3{double x=0,y=0,z=0;};
inline V3 operator+(V3 a,V3 b){return{a.x+b.x,a.y+b.y,a.z+b.z};}
inline V3 operator-(V3 a,V3 b){return{a.x-b.x,a.y-b.y,a.z-b.z};}
inline V3 operator*(double s,V3 a){return{s*a.x,s*a.y,s*a.z};}
inline V3 operator*(V3 a,double s){return s*a;}
inline V3& operator+=(V3&a,V3 b){a=a+b;return a;}
inline double dot(V3 a,V3 b){return a.x*b.x+a.y*b.y+a.z*b.z;}
inline V3 cross(V3 a,V3 b){return{a.y*b.z-a.z*b.y,a.z*b.x-a.x*b.z,a.x*b.y-a.y*b.x};}
inline double norm(V3 a){return std::sqrt(dot(a,a));}
struct Q{double w=1,x=0,y=0,z=0;};
inline Q operator*(Q a,Q b){return{a.w*b.w-a.x*b.x-a.y*b.y-a.z*b.z,a.w*b.x+a.x*b.w+a.y*b.z-a.z*b.y,a.w*b.y-a.x*b.z+a.y*b.w+a.z*b.x,a.w*b.z+a.x*b.y-a.y*b.x+a.z*b.w};}
inline Q unit(Q q){double n=1/std::sqrt(q.w*q.w+q.x*q.x+q.y*q.y+q.z*q.z);return{q.w*n,q.x*n,q.y*n,q.z*n};}
inline Q rotq(V3 a,double th){double n=norm(a);if(n==0)return{};double s=std::sin(th/2)/n;return{std::cos(th/2),a.x*s,a.y*s,a.z*s};}
struct M3{V3 c0,c1,c2;}; // columns
inline M3 mat(Q q){double w=q.w,x=q.x,y=q.y,z=q.z;return{{1-2*(y*y+z*z),2*(x*y+w*z),2*(x*z-w*y)},{2*(x*y-w*z),1-2*(x*x+z*z),2*(y*z+w*x)},{2*(x*z+w*y),2*(y*z-w*x),1-2*(x*x+y*y)}};}
inline V3 operator*(const M3&m,V3 v){return v.x*m.c0+v.y*m.c1+v.z*m.c2;}
inline V3 tmul(const M3&m,V3 v){return{dot(m.c0,v),dot(m.c1,v),dot(m.c2,v)};}
inline V3 rot(Q q,V3 v){return mat(q)*v;}

struct Phys{               // one trial's true physics (SI)
  double dt=20e-6;
  // object
  double m=0.2,L=0.1,s=0.025; double taper=0;    // taper: half width = s/2 + tan(taper)*x
  V3 g{0,0,-9.81};
  // pads
  double R=0.01; int nb=48; double Kt[2]={4e5,4e5},Kn[2]={6e5,6e5},zeta=0.2,zetaN=0.3; double hard=0; // N=k d(1+hard*d)
  double mu[2]={0.4,0.4}; double beta=0.6;       // <0: LuGre (blend=1); else elasto-plastic, elastic below beta
  double aniso=0;                                // mu along gripper x *(1+a/2), along z *(1-a/2)
  V3 pOff{};                                     // pressure centre offset (x,z)
  double visc=0;                                 // mu += visc*slip rate  (s/m)
  double stat=0,Dc=1e-4,tauAge=0.02;             // mu*(1+stat*theta)
  double loadE=0,N0=20;                          // mu*(N/N0)^e
  double adh=0;                                  // N per finger
  double heatK=0,heatTau=5;                      // mu*(1+heatK*E), E' = P - E/tau
  double zenR=0,zenTau=0.3;
  // jaw
  double grip=20,gripGain=1,gripOfs=0,jawM=0.15,jawBW=20,jawC=60,jawFc=0,jawK=0; bool padAlign=true;
  double lagA=0,lagTau=0.05,lagRec=3;            // grip share lost per metre of rim slip
  // environment
  int env=0;                                     // 0 plane, 1 line, -1 none
  V3 ep{};Q eq{}; double eKn=4e6,eKt=3e6,eMu=0.25,eLen=0.028,eZ=0.25;
  // extra
  V3 sprK{},sprA{},sprB{};                       // spring at object point sprB to world anchor sprA, stiffness per axis
  V3 sprF{};                                     // its preload
  double magF=0,magD=1e-3;                       // magnet pulling the left face towards the plate's frame (not through the sensor)
  V3 armK{};double armM=2,armZ=0.3;              // 0: rigid
  double ripA=0,ripL=3e-3,ripTh=0,ripPh=0;       // lateral wobble of the drive
  double ssL=0,ssTh=0,ssF=30,ssZ=0.15;           // stick-slip of the drive
  // path
  V3 g0{};double gripX=0;                        // gripper start, object's centre = g0 - gripX*x
  int kind=0; double speed=0.01,slope=0,len=0.015,ta=0.03,rest=0.5,tail=0.3,settle=0.25; // kind 0 push, 1 pivot (len in rad)
};
struct Row{double t;V3 gp;Q gq;V3 op;Q oq;V3 f[2],tq[2],pf,pt;V3 a;};
struct Energy{double win=0,diss=0,dampPad=0,dampEnv=0,dampJaw=0,envDiss=0,kin0=0,pot0=0,kin=0,pot=0,el0=0,el=0,minDiss=0;};

static const int NB=80;
struct Pad{
  int n; alignas(64) double x[NB],z[NB],k[NB],sx[NB],sz[NB],qx[NB],qz[NB],th[NB],ws[NB],Nn[NB];
};
inline void layPad(Pad&p,const Phys&P){
  int h=P.nb/2; p.n=2*h; double ga=M_PI*(3-std::sqrt(5.0));
  for(int i=0;i<h;i++){ double r=P.R*std::sqrt((i+0.5)/h),a=ga*i; p.x[i]=r*std::cos(a);p.z[i]=r*std::sin(a);p.x[h+i]=-p.x[i];p.z[h+i]=-p.z[i]; }
  // pressure weights: uniform times a linear gradient clipped at zero, solved for the wanted centre
  double gx=0,gz=0;
  for(int it=0;it<200;it++){ double S=0,cx=0,cz=0;
    for(int i=0;i<p.n;i++){p.k[i]=std::max(0.02,1+gx*p.x[i]/P.R+gz*p.z[i]/P.R);S+=p.k[i];cx+=p.k[i]*p.x[i];cz+=p.k[i]*p.z[i];}
    for(int i=0;i<p.n;i++)p.k[i]/=S; cx/=S;cz/=S; gx+=2*(P.pOff.x-cx)/P.R;gz+=2*(P.pOff.z-cz)/P.R; }
  for(int i=0;i<NB;i++){ if(i>=p.n){p.x[i]=p.z[i]=0;p.k[i]=0;} p.sx[i]=p.sz[i]=p.qx[i]=p.qz[i]=p.ws[i]=p.Nn[i]=0;p.th[i]=1; }
}
struct EPt{double a,b;double k;double z1=0,z2=0;};

struct Sim{
  const Phys&P; Energy E; bool doE; std::vector<Row> rows;
  Sim(const Phys&p,bool e=false):P(p),doE(e){}
  void run(){
    const double dt=P.dt; Pad pad[2]; layPad(pad[0],P);layPad(pad[1],P);
    // state
    V3 po=P.g0-V3{P.gripX,0,0},v{},w{}; Q qo{};
    V3 I{P.m*(2*P.s*P.s)/12,P.m*(P.L*P.L+P.s*P.s)/12,P.m*(P.L*P.L+P.s*P.s)/12};
    double F0=P.grip*P.gripGain+P.gripOfs,u=F0; double ta_=std::tan(P.taper);
    double jw=P.s/2+ta_*P.gripX-F0/(0.5*(P.Kn[0]+P.Kn[1])),jv=0,jref=0,jz=0; bool jset=false;
    double padSl=P.padAlign?ta_:0;
    V3 ua{},uv{}; if(P.armK.x>0) ua={0,0,P.m*P.g.z/P.armK.z};
    double s=0,sv=0,fs=0,fv=0,fl1=0; // command and filtered (stick-slip)
    double loss=0,lossF=0,heat=0;
    std::vector<EPt> ec;
    if(P.env==0){ for(int i=-1;i<=1;i++)for(int j=-1;j<=1;j++){double wt=(i?0.25:0.5)*(j?0.25:0.5);ec.push_back({i*P.s/2,j*P.s/2,wt});} }
    if(P.env==1){ int n=15;for(int i=0;i<n;i++)ec.push_back({P.eLen*((i+0.5)/n-0.5),0,1.0/n}); }
    V3 en=rot(P.eq,{1,0,0}),e1=rot(P.eq,{0,1,0}),e2=rot(P.eq,{0,0,1});
    double ctF[2],cnF[2]; for(int f=0;f<2;f++){ctF[f]=2*P.zeta*std::sqrt(P.Kt[f]*P.m/2);cnF[f]=2*P.zetaN*std::sqrt(P.Kn[f]*P.m/2);}
    double cE=2*P.eZ*std::sqrt(P.eKn*P.m),cEt=2*P.eZ*std::sqrt(P.eKt*P.m);
    double moveT=P.len/P.speed+P.ta; double T=P.rest+moveT+P.tail;
    long nSet=std::lround(P.settle/dt),nTot=nSet+std::lround(T/dt); long per=std::lround(0.004/dt);
    Row fl{}; double kf=dt/0.0005; bool first=true; double Nf[2]={F0,F0};
    double ax2=(1+P.aniso/2)*(1+P.aniso/2),az2=(1-P.aniso/2)*(1-P.aniso/2),iax2=1/ax2,iaz2=1/az2;
    double envN0=0;
    for(long it=0;it<=nTot;it++){
      double t=(it-nSet)*dt;
      // ---- commanded path
      double tm=t-P.rest,cv=0; if(tm>0&&tm<moveT){ if(tm<P.ta)cv=P.speed*0.5*(1-std::cos(M_PI*tm/P.ta)); else if(tm>moveT-P.ta)cv=P.speed*0.5*(1-std::cos(M_PI*(moveT-tm)/P.ta)); else cv=P.speed; }
      s+=cv*dt; sv=cv; double st=s,stv=sv;
      if(P.ssL>0||P.ssTh>0){ double q=P.kind==0?P.ssL:P.ssTh,wn=2*M_PI*P.ssF; double tgt=P.speed/q<0.4*P.ssF?q*std::floor(s/q):s; fl1+=dt/0.004*(tgt-fl1); double acc=wn*wn*(fl1-fs)-2*P.ssZ*wn*fv; fv+=acc*dt;fs+=fv*dt; st=fs;stv=fv; }
      V3 d{-std::cos(P.slope),0,std::sin(P.slope)},ln{std::sin(P.slope),0,std::cos(P.slope)};
      V3 gp=P.g0,gv{},gw{};Q gq{}; V3 gpc=P.g0;Q gqc{};
      if(P.kind==0){ gpc=P.g0+s*d; gp=P.g0+st*d; gv=stv*d; if(P.ripA>0){double k=2*M_PI/P.ripL;double am=P.ripA*std::min(1.0,s/1e-3),dam=(s<1e-3?P.ripA/1e-3:0);gp+=am*std::sin(k*s+P.ripPh)*ln;gv+=sv*(am*k*std::cos(k*s+P.ripPh)+dam*std::sin(k*s+P.ripPh))*ln;} }
      else { gqc=rotq({0,1,0},-s); double th=st,thv=stv; if(P.ripTh>0){double k=2*M_PI/0.06;double c=std::cos(k*s)-1;th+=P.ripTh*c;thv+=-P.ripTh*k*std::sin(k*s)*sv;
          double am=P.ripA,kk=2*M_PI/0.06;gp+=am*std::sin(kk*s)*V3{0,0,1};gv+=sv*am*kk*std::cos(kk*s)*V3{0,0,1};}
          gq=rotq({0,1,0},-th);gw={0,-thv,0}; }
      gp+=ua;gv+=uv;
      M3 Rg=mat(gq),Ro=mat(qo);
      V3 p=tmul(Rg,po-gp),v0=tmul(Rg,v-gv-cross(gw,po-gp)),Om=tmul(Rg,w-gw);
      M3 R{tmul(Rg,Ro.c0),tmul(Rg,Ro.c1),tmul(Rg,Ro.c2)};
      V3 Fo{},To{}; // on object, world
      double Ntot[2]={0,0},Pf=0,rim=0; V3 gF{}; double sPad=0,elN=0,elT=0,dampP=0;
      Row cur;
      for(int f=0;f<2;f++){
        Pad&B=pad[f]; double sg=f==0?1:-1;
        V3 no{-ta_,sg,0}; V3 m=R*no; double dpl=dot(m,p+R*V3{0,sg*P.s/2,0}); double imy=1/m.y; // plane m.r=dpl
        double a0=dpl*imy,ax=-m.x*imy,az=-m.z*imy;
        double lf=1; if(P.loadE!=0) lf=std::pow(std::max(Nf[f],0.2)/P.N0,P.loadE);
        double muB=P.mu[f]*lf*(1+P.heatK*heat);
        double Kn=P.Kn[f],Kt=P.Kt[f],ct=ctF[f],cn=cnF[f],beta=P.beta,ib=beta<1?1/(1-std::max(0.0,beta)):1; bool lugre=beta<0;
        double sF0=0,sF2=0,sN=0,tx=0,ty=0,tz=0,pw=0,rs=0,eN=0,eT=0,dD=0; // sums of forces in gripper frame (tangential x,z and N)
        double hL=P.L/2,hs=P.s/2;
        // object coordinates of a point r: R^T (r-p)
        const double *bx=B.x,*bz=B.z,*bk=B.k;double*sx=B.sx,*sz=B.sz,*qx=B.qx,*qz=B.qz,*th=B.th,*ws=B.ws,*NN=B.Nn;
        double visc=P.visc,stat=P.stat,adh=P.adh,hard=P.hard,zr=P.zenR,zdt=dt/P.zenTau,kw=dt/0.002,ageR=dt/P.tauAge,iDc=dt/P.Dc;
        double kminc=1e-12;
        #pragma GCC ivdep
        for(int i=0;i<B.n;i++){
          double X=bx[i],Z=bz[i],k=bk[i];
          double Y=a0+ax*X+az*Z; double dx=X-p.x,dy=Y-p.y,dz=Z-p.z;
          double vx=v0.x+Om.y*dz-Om.z*dy,vy=v0.y+Om.z*dx-Om.x*dz,vz=v0.z+Om.x*dy-Om.y*dx;
          double de=sg*Y-(jw+padSl*X), dd=sg*(m.x*vx+m.y*vy+m.z*vz)*imy-jv;
          double xo=R.c0.x*dx+R.c0.y*dy+R.c0.z*dz,zo=R.c2.x*dx+R.c2.y*dy+R.c2.z*dz;
          double c1=std::min(std::max(0.5+(hL-std::fabs(xo))*1000,0.0),1.0),c2=std::min(std::max(0.5+(hs-std::fabs(zo))*1000,0.0),1.0);
          double kk=k*c1*c2;
          double N=kk*(Kn*de*(1+hard*de)+cn*dd); N=(de>0&&N>0)?N:0;
          double Nl=N+adh*kk;
          double mui=muB*(1+stat*th[i])+visc*ws[i];
          double lim=mui*Nl; double kt=Kt*k+kminc; double zss=lim/kt+1e-13;
          double px=sx[i]-zr*qx[i],pz=sz[i]-zr*qz[i]; // elastic part
          double rho=std::sqrt(px*px*iax2+pz*pz*iaz2)/zss;
          double al=(rho-beta)*ib; al=std::min(std::max(al,0.0),1.0); al=al*al*(3-2*al); al=(px*vx+pz*vz>0)?al:0; al=lugre?1:al;
          double vm=std::sqrt(ax2*vx*vx+az2*vz*vz); double c=al*vm*dt/zss;
          double nx=(px+vx*dt)/(1+c*iax2),nz=(pz+vz*dt)/(1+c*iaz2);
          double r2=std::sqrt(nx*nx*iax2+nz*nz*iaz2)/zss; double sc=r2>1?1/r2:1; nx*=sc;nz*=sc;
          double rx=(nx-px)/dt,rz=(nz-pz)/dt;
          double ux=vx-rx,uz=vz-rz; double sl=std::sqrt(ux*ux+uz*uz);
          ws[i]+=kw*(sl-ws[i]); th[i]+=(1-th[i])*ageR-sl*th[i]*iDc; th[i]=std::max(th[i],0.0);
          sx[i]=nx+zr*qx[i];sz[i]=nz+zr*qz[i]; qx[i]+=zdt*(sx[i]-qx[i]);qz[i]+=zdt*(sz[i]-qz[i]);
          double Fx=kt*nx+ct*k*rx,Fz=kt*nz+ct*k*rz; double fm=std::sqrt(Fx*Fx*iax2+Fz*Fz*iaz2); double s2=fm>lim?lim/(fm+1e-15):1; Fx*=s2;Fz*=s2;
          // on the object: -Fx,-Fz, and N along the inward normal -m*sg/... (y component -sg*N)
          double gx=-Fx-sg*N*m.x*imy,gy=-sg*N,gz=-Fz-sg*N*m.z*imy;
          NN[i]=N;
          sF0+=gx;sF2+=gz;sN+=N; tx+=dy*gz-dz*gy;ty+=dz*gx-dx*gz;tz+=dx*gy-dy*gx; // about object's centre
          pw+=Fx*ux+Fz*uz; rs+=k*std::sqrt(vx*vx+vz*vz);
          double N0e=kk*(Kn*de*(1+hard*de)); N0e=de>0?N0e:0;
          eN+=de>0?kk*Kn*(de*de/2+hard*de*de*de/3):0; eT+=0.5*kt*(nx*nx+nz*nz); dD+=(N-N0e)*dd+(Fx-kt*nx)*rx+(Fz-kt*nz)*rz;
        }
        double sF1=-sg*sN;
        V3 fg{sF0,sF1,sF2},tg{tx,ty,tz}; Fo+=Rg*fg;To+=Rg*tg;gF+=Rg*fg;
        Ntot[f]=sN; Nf[f]+=(sN-Nf[f])*dt/0.005; Pf+=pw; rim+=0.5*rs; elN+=eN;elT+=eT;dampP+=dD;
        // sensor: about the gripper origin projected along gripper y on the object's side
        V3 c{0,a0,0}; V3 tc=tg+cross(p-c,fg); cur.f[f]=fg;cur.tq[f]=tc;
      }
      if(it==0) ;
      // ---- environment
      V3 Fe{},Te{}; double eEl=0,eDi=0,eDa=0;
      if(P.env==0&&it>=0){
        for(auto&c:ec){ V3 ro=Ro*V3{-P.L/2,c.a,c.b}; V3 x=po+ro,vx=v+cross(w,ro); double pen=-dot(x-P.ep,en),pd=-dot(vx,en);
          double N=c.k*(P.eKn*pen+cE*pd); if(pen<=0||N<0)N=0;
          double u1=dot(vx,e1),u2=dot(vx,e2),o1=c.z1,o2=c.z2; double n1=o1+u1*dt,n2=o2+u2*dt,kt=c.k*P.eKt,lim=P.eMu*N/kt;
          double r=std::sqrt(n1*n1+n2*n2); if(r>lim){double q=r>0?lim/r:0;n1*=q;n2*=q;} 
          double r1=(n1-o1)/dt,r2=(n2-o2)/dt; c.z1=n1;c.z2=n2;
          double F1=kt*n1+c.k*cEt*r1,F2=kt*n2+c.k*cEt*r2,fm=std::hypot(F1,F2); if(fm>P.eMu*N){double q=P.eMu*N/(fm+1e-15);F1*=q;F2*=q;}
          V3 fo=N*en-F1*e1-F2*e2; Fe+=fo; To+=cross(ro,fo);Te+=cross(x-P.ep,fo);
          if(doE){eEl+=pen>0?c.k*P.eKn*pen*pen/2:0;eEl+=0.5*kt*(n1*n1+n2*n2);eDi+=F1*(u1-r1)+F2*(u2-r2);eDa+=(N-(pen>0?c.k*P.eKn*pen:0))*pd+(F1-kt*n1)*r1+(F2-kt*n2)*r2;}
        }
      } else if(P.env==1){
        for(auto&c:ec){ V3 x=P.ep+c.a*e1; V3 xo=tmul(Ro,x-po); if(std::fabs(xo.y)>P.s/2||std::fabs(xo.x)>P.L/2||xo.z>0){c.z1=c.z2=0;continue;}
          double pen=xo.z+P.s/2; V3 ro=x-po; V3 vo=tmul(Ro,v+cross(w,ro)); double pd=-vo.z; double N=c.k*(P.eKn*pen+cE*pd); if(pen<=0||N<0)N=0;
          double kt=c.k*P.eKt,o1=c.z1,o2=c.z2,n1=o1+vo.x*dt,n2=o2+vo.y*dt,lim=P.eMu*N/kt,r=std::sqrt(n1*n1+n2*n2); if(r>lim){double q=r>0?lim/r:0;n1*=q;n2*=q;}
          double r1=(n1-o1)/dt,r2=(n2-o2)/dt;c.z1=n1;c.z2=n2;
          double F1=kt*n1+c.k*cEt*r1,F2=kt*n2+c.k*cEt*r2,fm=std::hypot(F1,F2); if(fm>P.eMu*N){double q=P.eMu*N/(fm+1e-15);F1*=q;F2*=q;}
          V3 fo=Ro*V3{-F1,-F2,N}; Fe+=fo;To+=cross(ro,fo);Te+=cross(x-P.ep,fo);
          if(doE){eEl+=pen>0?c.k*P.eKn*pen*pen/2:0;eEl+=0.5*kt*(n1*n1+n2*n2);eDi+=F1*(vo.x-r1)+F2*(vo.y-r2);eDa+=(N-(pen>0?c.k*P.eKn*pen:0))*pd+(F1-kt*n1)*r1+(F2-kt*n2)*r2;}
        }
      }
      Fo+=Fe; envN0=dot(Fe,en);
      if(P.sprK.x>0||norm(P.sprF)>0){ V3 ro=Ro*P.sprB; V3 e=po+ro-P.sprA; V3 f{P.sprF.x-P.sprK.x*e.x,P.sprF.y-P.sprK.y*e.y,P.sprF.z-P.sprK.z*e.z}; Fo+=f;To+=cross(ro,f); }
      if(P.magF>0&&P.env==0){ V3 ro=Ro*V3{-P.L/2,0,0}; double gap=std::max(0.0,dot(po+ro-P.ep,en)); double q=1+gap/P.magD; V3 f=(-P.magF/(q*q))*en; Fo+=f;To+=cross(ro,f); }
      V3 Fg=Fo+P.m*P.g; V3 acc=(1/P.m)*Fg;
      // ---- log (forces low-passed 0.5 ms)
      cur.pf=Fe;cur.pt=Te;
      if(first){fl=cur;first=false;}
      for(int f=0;f<2;f++){fl.f[f]+=kf*(cur.f[f]-fl.f[f]);fl.tq[f]+=kf*(cur.tq[f]-fl.tq[f]);} fl.pf+=kf*(cur.pf-fl.pf);fl.pt+=kf*(cur.pt-fl.pt); fl.a+=kf*(acc-fl.a);
      if(it>=nSet&&(it-nSet)%per==0){ Row r=fl; r.t=t;r.gp=gpc;r.gq=gqc;r.op=po;r.oq=qo; rows.push_back(r); }
      if(doE&&it>=nSet){ V3 wb=tmul(Ro,w); double kin=0.5*P.m*dot(v,v)+0.5*(I.x*wb.x*wb.x+I.y*wb.y*wb.y+I.z*wb.z*wb.z)+P.jawM*jv*jv; double pot=-P.m*dot(P.g,po); double el=elN+elT+eEl;
        if(it==nSet){E.kin0=kin;E.pot0=pot;E.el0=el;} E.kin=kin;E.pot=pot;E.el=el;
        // power put in by the gripper's motion (pads' roots) and the jaw's actuator
        V3 tqG{}; for(int f=0;f<2;f++){ tqG+=Rg*(cur.tq[f]); }
        double pin=0; for(int f=0;f<2;f++){ V3 fg=cur.f[f]; Pad&B=pad[f];(void)B; V3 m=R*V3{-ta_,f==0?1.0:-1.0,0}; double a0=dot(m,p+R*V3{0,(f==0?1:-1)*P.s/2,0})/m.y; V3 cw=gp+Rg*V3{0,a0,0}; pin+=dot(Rg*fg,gv+cross(gw,cw-gp))+dot(Rg*cur.tq[f],gw); }
        E.win+=(pin-2*u*jv)*dt; E.diss+=Pf*dt; E.dampPad+=dampP*dt;E.envDiss+=eDi*dt;E.dampEnv+=eDa*dt;E.dampJaw+=P.jawC*jv*jv*dt; E.minDiss=std::min(E.minDiss,Pf);
      }
      // ---- integrate object
      v+=dt*acc; 
      V3 wb=tmul(Ro,w),tb=tmul(Ro,To); V3 Iw{I.x*wb.x,I.y*wb.y,I.z*wb.z}; V3 gy=cross(wb,Iw); wb+=dt*V3{(tb.x-gy.x)/I.x,(tb.y-gy.y)/I.y,(tb.z-gy.z)/I.z};
      V3 po_old=po; po+=dt*v; double wn=norm(wb); if(wn>0) qo=unit(qo*rotq(wb,wn*dt)); w=mat(qo)*wb; (void)po_old;
      // ---- jaw
      double Ft=F0; if(P.lagA>0){ loss+=dt*(t>0?(P.lagA*rim-loss/P.lagRec):0.0); lossF+=dt*(loss-lossF)/P.lagTau; Ft=F0*std::max(0.2,1-lossF);} 
      u+=dt*2*M_PI*P.jawBW*(Ft-u);
      if(t>-0.02&&!jset){jset=true;jref=jw;}
      double hold=jset?P.jawK*(jw-jref):0.0; // grows when the jaw opens (positive closes)
      double ff=0; if(P.jawFc>0){ double kz=2e6; jz+=jv*dt; double l=P.jawFc/kz; jz=std::min(std::max(jz,-l),l); ff=kz*jz; }
      jv+=dt*(Ntot[0]+Ntot[1]-2*u-2*hold-P.jawC*jv-ff)/(2*P.jawM); jw+=jv*dt;
      // ---- heat, arm
      if(P.heatK!=0&&t>0) heat+=dt*(Pf-heat/P.heatTau);
      if(P.armK.x>0){ double zx=2*P.armZ; V3 a{(-P.armK.x*ua.x-gF.x)/P.armM-zx*std::sqrt(P.armK.x/P.armM)*uv.x,(-P.armK.y*ua.y-gF.y)/P.armM-zx*std::sqrt(P.armK.y/P.armM)*uv.y,(-P.armK.z*ua.z-gF.z)/P.armM-zx*std::sqrt(P.armK.z/P.armM)*uv.z};
        uv+=dt*a;ua+=dt*uv; }
      if(!(std::fabs(po.z-P.g0.z)<1)){ fprintf(stderr,"diverged at t=%g\n",t); rows.clear(); return; }
    }
  }
};
