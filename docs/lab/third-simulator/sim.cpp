// The simulator of docs/lab/third-simulator.md, as it was run: evidence, not kept to the style of the repository.
//   g++ -O2 -o sim sim.cpp && ./sim FOLDER seed=21 kt=3e5 mu=0.44 mup=0.25 mismatch=0.35 stiffexp=0.33 dahl=2 crown=0.1
// Independent bristle simulator: prism between two pads, pushed by a plane or a line. Explicit symplectic Euler.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <random>
#include <string>
#include <sys/stat.h>
#include <vector>
using namespace std;
struct V {
    double x, y, z;
};
static inline V operator+(V a, V b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
static inline V operator-(V a, V b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
static inline V operator*(double s, V a) { return {s * a.x, s * a.y, s * a.z}; }
static inline double dot(V a, V b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
static inline V cross(V a, V b) { return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x}; }
struct Q {
    double w, x, y, z;
};
static Q qm(Q a, Q b) {
    return {a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z, a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y,
            a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x, a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w};
}
static Q qn(Q a) {
    double n = 1 / sqrt(a.w * a.w + a.x * a.x + a.y * a.y + a.z * a.z);
    return {a.w * n, a.x * n, a.y * n, a.z * n};
}
static Q qrot(V r) {
    double a = sqrt(dot(r, r));
    if (a < 1e-14)
        return {1, r.x / 2, r.y / 2, r.z / 2};
    double s = sin(a / 2) / a;
    return {cos(a / 2), s * r.x, s * r.y, s * r.z};
}
struct M {
    V c0, c1, c2;
}; // columns
static M mat(Q q) {
    return {{1 - 2 * (q.y * q.y + q.z * q.z), 2 * (q.x * q.y + q.w * q.z), 2 * (q.x * q.z - q.w * q.y)},
            {2 * (q.x * q.y - q.w * q.z), 1 - 2 * (q.x * q.x + q.z * q.z), 2 * (q.y * q.z + q.w * q.x)},
            {2 * (q.x * q.z + q.w * q.y), 2 * (q.y * q.z - q.w * q.x), 1 - 2 * (q.x * q.x + q.y * q.y)}};
}
static inline V mul(const M &m, V a) { return a.x * m.c0 + a.y * m.c1 + a.z * m.c2; }
static inline V tmul(const M &m, V a) { return {dot(m.c0, a), dot(m.c1, a), dot(m.c2, a)}; }
map<string, double> P;
double par(const char *k, double d) {
    auto i = P.find(k);
    return i == P.end() ? d : i->second;
}
struct Obj {
    string id;
    double L, S, m;
};
struct Cond {
    int prim, obj;
    double grip, speed, slope, off;
    int run;
};
struct Bris {
    double u, v, w;
    double sx, sz;
};
mt19937_64 rng;
double nrm(double s = 1) {
    normal_distribution<double> d(0, 1);
    return s * d(rng);
}
double clip(double x, double a) { return max(-a, min(a, x)); }
int main(int argc, char **argv) {
    string out = argv[1];
    for (int i = 2; i < argc; i++) {
        string s = argv[i];
        size_t e = s.find('=');
        P[s.substr(0, e)] = atof(s.c_str() + e + 1);
    }
    rng.seed((uint64_t)par("seed", 1));
    mkdir(out.c_str(), 0755);
    mkdir((out + "/trials").c_str(), 0755);
    const double R = 0.010;
    const bool noedge = par("noedge", 0) > 0;
    double kt = par("kt", 2e6), kn = par("kn", 0);
    if (kn <= 0)
        kn = min(3e6, max(kt * 1.5, 0.0 + kt * 3 > 3e6 ? 3e6 : kt * 3));
    double pst = par("stiffexp", 0), qd = par("dahl", 2), crown = par("crown", 0.2);
    double mu0 = par("mu", 0.43), mup0 = par("mup", 0.26);
    double kp = par("kp", 5e6);
    double muvar = par("muvar", 0.035);
    double mis = par("mismatch", 0);                     // mu1 = (1+mis) mu2, mean mu kept
    double poff = par("poff_mm", 0) * 1e-3;              // pressure centre, gripper X
    double taper = par("taper", 0), Kj = par("kjaw", 0); // rise of face angle per object x, jaw stiffness
    double cslip = par("gripslip", 0), tlag = par("griplag", 0.05);
    double tiltp = par("tilt_deg", 0) * M_PI / 180, tiltl = par("line_deg", 0) * M_PI / 180;
    double gain1 = par("gain1", 1);
    double loadexp = par("loadexp", 0), N0 = 25;
    double wear = par("wear", 0);
    double visc = par("visc", 0);             // relative rise per m/s
    double kspr = par("spring", 0);           // object-gripper spring N/m, along gripper X and Z
    double lever = par("lever", 0);           // grip change per newton of finger tangential X
    double bend = par("bend_um_n", 0) * 1e-6; // gripper displaced by load, um per N
    double bendr = par("bend_mrad_nm", 0) * 1e-3;
    double stat = par("static", 0); // static friction excess
    int npl = (int)par("linear", 18), npv = (int)par("pivot", 12);
    double dt = par("dt", kt > 6.5e5 ? 18e-6 : 30e-6);
    int N = (int)par("bristles", 48);
    vector<Obj> O = {{"alu", 0.1, 0.025, 0.2005}, {"abs", 0.09, 0.03, 0.121}};
    double grips[3] = {18, 25, 35}, sp[3] = {0.006, 0.012, 0.025}, sl[3] = {-0.3, 0, 0.3}, ws[2] = {0.12, 0.4},
           offs[2] = {0, 0.015};
    vector<Cond> C;
    {
        int n = 0;
        for (int rep = 0; rep < 2; rep++)
            for (int i = 0; i < 3; i++)
                for (int j = 0; j < 3; j++) {
                    if (n++ >= npl)
                        continue;
                    C.push_back(
                        {0, (i + j + rep) % 2, grips[i], sp[(rep == 0 ? i + j : i + 2 * j + 1) % 3], sl[j], 0, 0});
                }
        n = 0;
        for (int rep = 0; rep < 2; rep++)
            for (int i = 0; i < 3; i++)
                for (int j = 0; j < 2; j++) {
                    if (n++ >= npv)
                        continue;
                    C.push_back({1, (i + j + rep) % 2, grips[i], ws[(i + rep) % 2], 0, offs[j], 0});
                }
    }
    vector<Cond> T;
    {
        vector<Cond> A = C, B = C;
        shuffle(A.begin(), A.end(), rng);
        shuffle(B.begin(), B.end(), rng);
        for (auto &c : B)
            c.run = 1;
        T = A;
        T.insert(T.end(), B.begin(), B.end());
    }
    // sensor offsets, constant over the set
    double fu = 0.15, tu = 0.002, pu = 0.3, ptu = 0.006;
    double ob[18];
    for (int i = 0; i < 18; i++) {
        double u = i < 12 ? ((i % 6) < 3 ? fu : tu) : ((i % 6) < 3 ? pu : ptu);
        ob[i] = par("nobias", 0) > 0 ? 0 : clip(nrm(0.4 * u), 0.9 * u);
    }
    FILE *f = fopen((out + "/dataset.toml").c_str(), "w");
    fprintf(f, "format = \"stickslip-dataset/1\"\nname = \"third-bench\"\nsample_rate_hz = 250.0\ngravity_m_s2 = [0.0, "
               "0.0, -9.81]\n\n");
    for (auto &o : O)
        fprintf(f, "[[objects]]\nid = \"%s\"\nshape = \"prism\"\nlength_m = %g\nside_m = %g\nmass_kg = %g\n\n",
                o.id.c_str(), o.L, o.S, o.m);
    fprintf(f, "[fingers]\ncontact = \"disc\"\ndiameter_m = 0.02\n\n[pushers.linear_push]\ncontact = "
               "\"plane\"\n\n[pushers.pivot]\ncontact = \"line\"\nlength_m = 0.028\n\n");
    fprintf(f,
            "[sensors.finger]\nforce_noise_n = 0.02\nforce_uncertainty_n = %g\ntorque_noise_nm = "
            "0.0004\ntorque_uncertainty_nm = %g\n\n[sensors.pusher]\nforce_noise_n = 0.04\nforce_uncertainty_n = "
            "%g\ntorque_noise_nm = 0.001\ntorque_uncertainty_nm = %g\n\n[sensors.pose]\nposition_noise_m = "
            "0.00003\nrotation_noise_rad = 0.0003\n",
            fu, tu, pu, ptu);
    fclose(f);
    FILE *ft = fopen((out + "/trials.csv").c_str(), "w");
    fprintf(ft, "trial,file,object,primitive,grip_n,speed_m_s,speed_rad_s,slope_rad,pusher_offset_m,run,pusher_x_m,"
                "pusher_y_m,pusher_z_m,pusher_qw,pusher_qx,pusher_qy,pusher_qz\n");
    for (size_t it = 0; it < T.size(); it++) {
        Cond c = T[it];
        Obj o = O[c.obj];
        double muf = mu0 * exp(nrm(muvar)) * (1 - wear * it / max<size_t>(1, T.size() - 1)),
               mup = mup0 * exp(nrm(muvar));
        double m1 = muf * (1 + mis) / (1 + mis / 2), m2 = muf / (1 + mis / 2);
        double nf1 = 1 + nrm(0.005), nf2 = 1 + nrm(0.005);
        m1 *= nf1;
        m2 *= nf2;
        double gripF = c.grip * (1 + nrm(0.003));
        // bristles
        vector<Bris> b[2];
        double sum[2] = {0, 0};
        for (int j = 0; j < 2; j++) {
            for (int i = 0; i < N; i++) {
                double r = R * sqrt((i + 0.5) / N), a = i * 2.399963229728653 + j * 1.1;
                if (par("sym", 0) > 0) {
                    int h = i / 2;
                    r = R * sqrt((h + 0.5) / (N / 2));
                    a = h * 2.399963229728653 + (i % 2) * M_PI;
                }
                Bris q{r * cos(a), r * sin(a), 1 - crown * r * r / R / R, 0, 0};
                b[j].push_back(q);
            }
            double cu = 0, cv = 0, uu = 0;
            for (auto &q : b[j]) {
                sum[j] += q.w;
                cu += q.w * q.u;
                cv += q.w * q.v;
                uu += q.w * q.u * q.u;
            }
            cu /= sum[j];
            cv /= sum[j];
            uu /= sum[j];
            double s2 = 0;
            for (auto &q : b[j]) {
                q.u -= cu;
                q.v -= cv;
                q.w *= 1 + poff * q.u / uu;
                s2 += q.w;
            }
            for (auto &q : b[j])
                q.w /= s2;
        }
        static double bu[2][256], bv[2][256], bw[2][256], bsx[2][256], bsz[2][256];
        for (int j = 0; j < 2; j++)
            for (int i = 0; i < N; i++) {
                bu[j][i] = b[j][i].u;
                bv[j][i] = b[j][i].v;
                bw[j][i] = b[j][i].w;
                bsx[j][i] = bsz[j][i] = 0;
            }
        double L = o.L, S = o.S, mass = o.m;
        V I = {mass * (S * S + S * S) / 12, mass * (L * L + S * S) / 12, mass * (L * L + S * S) / 12};
        V p = {nrm(1e-4), 0, nrm(1e-4)};
        Q q = qn(qrot({0, nrm(4e-4), 0}));
        V v = {0, 0, 0}, w = {0, 0, 0};
        double wj = S / 2 + 0.0 - gripF / kn, wd = 0, mj = par("mjaw", 0.05);
        double w00 = 0;
        bool w0set = false;
        V po;
        Q pq;
        if (c.prim == 0) {
            po = {-L / 2 - 0.0004, 0, 0};
            pq = {1, 0, 0, 0};
        } else {
            po = {-L / 2 + 0.005 + c.off, 0, -S / 2 - 0.0003};
            pq = {M_SQRT1_2, 0, -M_SQRT1_2, 0};
        }
        M Rp0 = mat(pq);
        Q pqt = c.prim == 0 ? qm(pq, qrot({0, tiltp, 0})) : qm(pq, qrot({0, 0, tiltl}));
        M Rp = mat(pqt);
        int np = c.prim == 0 ? 25 : 15;
        vector<V> pp(np), ps(np, V{0, 0, 0});
        if (c.prim == 0)
            for (int i = 0; i < 25; i++)
                pp[i] = {-L / 2, S * ((i % 5) / 4.0 - 0.5), S * ((i / 5) / 4.0 - 0.5)};
        else
            for (int i = 0; i < 15; i++)
                pp[i] = {0, 0.028 * (i / 14.0 - 0.5), 0};
        double kpi = kp / np, ktp = 0.7 * kpi, cp = 0.5 * sqrt(kp * mass) / np;
        double cn = 2 * par("zn", 0.15) * sqrt(kn * mass), ct = 2 * par("zt", 0.25) * sqrt(kt * mass),
               cj = 2 * 0.35 * sqrt(2 * kn * mj);
        // drive profile: progress s(t) with pause
        double path = c.prim == 0 ? par("path", 0.012) : par("turn", c.speed > 0.2 ? 0.45 : 0.32), spd = c.speed,
               ta = 0.03;
        double trest = 0.30, tp = 0.35, s1 = 0.55 * path, t1 = s1 / spd + ta, s2 = path - s1, t2 = s2 / spd + ta;
        auto seg = [&](double t, double s, double tt) -> pair<double, double> { // smooth ramp up/down, distance s in tt
            if (t <= 0)
                return {0, 0};
            if (t >= tt)
                return {s, 0};
            double V0 = spd, x, vv;
            if (t < ta) {
                double a = t / ta;
                vv = V0 * 0.5 * (1 - cos(M_PI * a));
                x = V0 * 0.5 * (t - ta / M_PI * sin(M_PI * a));
            } else if (t < tt - ta) {
                vv = V0;
                x = V0 * (ta / 2 + t - ta);
            } else {
                double a = (tt - t) / ta;
                vv = V0 * 0.5 * (1 - cos(M_PI * a));
                x = s - V0 * 0.5 * ((tt - t) - ta / M_PI * sin(M_PI * a));
            }
            return {x, vv};
        };
        double tend = trest + t1 + tp + t2 + 0.3;
        char nm[32];
        snprintf(nm, 32, "t%04zu", it);
        fprintf(ft, "%s,trials/%s.csv,%s,%s,%g,", nm, nm, o.id.c_str(), c.prim == 0 ? "linear_push" : "pivot", c.grip);
        if (c.prim == 0)
            fprintf(ft, "%g,,%g,,", c.speed, c.slope);
        else
            fprintf(ft, ",%g,,%g,", c.speed, c.off);
        fprintf(ft, "%d,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g\n", c.run, po.x, po.y, po.z, pq.w, pq.x, pq.y, pq.z);
        FILE *g = fopen((out + "/trials/" + nm + ".csv").c_str(), "w");
        fprintf(g, "t_s,grip_cmd_n,gripper_x_m,gripper_y_m,gripper_z_m,gripper_qw,gripper_qx,gripper_qy,gripper_qz,"
                   "object_x_m,object_y_m,object_z_m,object_qw,object_qx,object_qy,object_qz");
        for (const char *b : {"finger1", "finger2", "pusher"})
            fprintf(g, ",%s_fx_n,%s_fy_n,%s_fz_n,%s_tx_nm,%s_ty_nm,%s_tz_nm", b, b, b, b, b, b);
        fprintf(g, "\n");
        double tset = 0.25;
        long nset = lround(tset / dt), ns = lround(0.004 / dt);
        double dtt = 0.004 / ns;
        long steps = nset + lround(tend / dtt);
        double gl = 0;
        V lastF = {0, 0, 0};
        double lastT = 0;
        double lm = 0;
        V bdp = {0, 0, 0};
        double bda = 0;
        double prevN[2] = {gripF, gripF};
        for (long k = 0; k <= steps; k++) {
            double t = (k - nset) * dtt;
            // gripper pose and velocity
            auto a = seg(t - trest, s1, t1), bb = seg(t - trest - t1 - tp, s2, t2);
            double s = a.first + bb.first, sv = a.second + bb.second;
            V gp = {0, 0, 0}, gv = {0, 0, 0}, gw = {0, 0, 0};
            Q gq = {1, 0, 0, 0};
            if (c.prim == 0) {
                V d = {-cos(c.slope), 0, -sin(c.slope)};
                d.z = sin(c.slope);
                gp = s * d;
                gv = sv * d;
            } else {
                gq = qrot({0, -s, 0});
                gw = {0, -sv, 0};
            }
            V gpr = gp;
            Q gqr = gq;
            if (bend > 0 || bendr > 0) { // bent gripper: low passed load
                V nb = bend * lastF;
                double na = bendr * lastT;
                double rate = 1 / 0.003;
                V vb = rate * (nb - bdp);
                double va = rate * (na - bda);
                bdp = bdp + dtt * vb;
                bda += dtt * va;
                gp = gp - bdp;
                gv = gv - vb;
                gq = qm(gq, qrot({0, -bda, 0}));
                gw.y -= va;
            }
            M Rg = mat(gq), Ro = mat(q);
            V Ft = {0, 0, 0}, Tt = {0, 0, 0};
            V ff[2], tt[2];
            double nrmN[2];
            double msl = 0;
            for (int j = 0; j < 2; j++) {
                double sy = j == 0 ? 1 : -1;
                V F = {0, 0, 0}, Tq = {0, 0, 0};
                double Nn = 0;
                // patch centre on the object's side
                V og = tmul(Ro, gp - p), ey = tmul(Ro, Rg.c1);
                double tc = (sy * (S / 2 + taper * og.x) - og.y) / ey.y;
                V Cc = gp + tc * Rg.c1;
                V nl = {sy * taper * -1, 1, 0}; // face sy*y = S/2+taper x  -> outward normal (-taper, sy, 0)
                nl = {-taper, sy, 0};
                double nn = 1 / sqrt(1 + taper * taper);
                nl = nn * nl;
                V nw = mul(Ro, nl);
                if (k == 0)
                    prevN[j] = gripF;
                double muj = (j == 0 ? m1 : m2);
                if (loadexp != 0)
                    muj *= pow(max(prevN[j], 1.0) / N0, loadexp);
                // everything below is affine in the bristle's place (u, v): exact, and fast
                V A = gp + (sy * wj) * Rg.c1, B = Rg.c0 + (sy * taper) * Rg.c1, Cv = Rg.c2;
                V oa = tmul(Ro, A - p), obx = tmul(Ro, B), ocx = tmul(Ro, Cv);
                double d0 = (sy * oa.y - S / 2 - taper * oa.x) * nn, du = (sy * obx.y - taper * obx.x) * nn,
                       dv = (sy * ocx.y - taper * ocx.x) * nn;
                V va0 = v + cross(w, A - p) - gv - cross(gw, A - gp) - (sy * wd) * Rg.c1, vb0 = cross(w - gw, B),
                  vc0 = cross(w - gw, Cv);
                double n0 = dot(va0, nw), nu = dot(vb0, nw), nv = dot(vc0, nw), nx = dot(nw, Rg.c0),
                       nz = dot(nw, Rg.c2);
                double x0 = dot(va0, Rg.c0) - n0 * nx, xu = dot(vb0, Rg.c0) - nu * nx, xv = dot(vc0, Rg.c0) - nv * nx;
                double z0 = dot(va0, Rg.c2) - n0 * nz, zu = dot(vb0, Rg.c2) - nu * nz, zv = dot(vc0, Rg.c2) - nv * nz;
                double sgs = kt;
                if (pst > 0)
                    sgs *= pow(max(prevN[j], 0.5) / 25, pst);
                double *U = bu[j], *W = bw[j], *Vv = bv[j], *X = bsx[j], *Z = bsz[j];
                double S_[12] = {0};
                double s0 = 0, s1_ = 0, s2_ = 0, s3 = 0, s4 = 0, s5 = 0, s6 = 0, s7 = 0, s8 = 0, s9 = 0, s10 = 0,
                       s11 = 0, sl_ = 0;
                double lx = L / 2, lz = S / 2;
                for (int i = 0; i < N; i++) {
                    double u = U[i], vv = Vv[i], wt = W[i];
                    double d = d0 + du * u + dv * vv;
                    double ox = oa.x + obx.x * u + ocx.x * vv, oz = oa.z + obx.z * u + ocx.z * vv;
                    double vn = n0 + nu * u + nv * vv, vx = x0 + xu * u + xv * vv, vz = z0 + zu * u + zv * vv;
                    double fn = wt * (-kn * d + cn * vn);
                    bool on = (d < 0) & (fn > 0) & (fabs(ox) < lx) & ((fabs(oz) < lz) | noedge);
                    fn = on ? fn : 0.0;
                    double va = sqrt(vx * vx + vz * vz);
                    double mu = muj * (1 + visc * va);
                    double sig = sgs * wt;
                    double smax = mu * fn / sig + 1e-15;
                    double sx = X[i], sz = Z[i];
                    double sm = sqrt(sx * sx + sz * sz);
                    double r = sm / smax;
                    r = r > 1 ? 1 : r;
                    double fac = va / smax * (qd < 1.5 ? 1.0 : (qd < 2.5 ? r : r * r));
                    double dx = vx - fac * sx, dz = vz - fac * sz;
                    sx += dtt * dx;
                    sz += dtt * dz;
                    sm = sqrt(sx * sx + sz * sz);
                    double cl = sm > smax ? smax / sm : 1.0;
                    bool cc = sm > smax;
                    sx *= cl;
                    sz *= cl;
                    dx = cc ? 0.0 : dx;
                    dz = cc ? 0.0 : dz;
                    sx = on ? sx : 0.0;
                    sz = on ? sz : 0.0;
                    X[i] = sx;
                    Z[i] = sz;
                    double c1 = on ? ct * wt : 0.0;
                    double fx = -sig * sx - c1 * dx, fz = -sig * sz - c1 * dz;
                    s0 += fn;
                    s1_ += fx;
                    s2_ += fz;
                    s3 += u * fn;
                    s4 += u * fx;
                    s5 += u * fz;
                    s6 += vv * fn;
                    s7 += vv * fx;
                    s8 += vv * fz;
                    s9 += d * fn;
                    s10 += d * fx;
                    s11 += d * fz;
                    sl_ += on ? 0.5 * wt * va : 0.0;
                }
                (void)S_;
                Nn = s0;
                msl += sl_;
                auto vec = [&](double a, double bx, double cz) { return (-a) * nw + bx * Rg.c0 + cz * Rg.c2; };
                V G0 = vec(s0, s1_, s2_), Gu = vec(s3, s4, s5), Gv = vec(s6, s7, s8), Gd = vec(s9, s10, s11);
                V tA = cross(B, Gu) + cross(Cv, Gv) - cross(nw, Gd);
                F = G0;
                Tq = cross(A - Cc, G0) + tA;
                Ft = Ft + F;
                Tt = Tt + cross(A - p, G0) + tA;
                ff[j] = tmul(Rg, F);
                tt[j] = tmul(Rg, Tq);
                nrmN[j] = Nn;
                prevN[j] += (Nn - prevN[j]) * dtt / 0.002;
            }
            V fingF = Ft;
            lastF = 0.02 * Ft + 0.98 * lastF;
            lastT = 0.02 * (tt[0].y + tt[1].y) + 0.98 * lastT;
            // pusher
            V Fp = {0, 0, 0}, Tp = {0, 0, 0};
            for (int i = 0; i < np; i++) {
                V Pw;
                double pen;
                V n;
                V loc;
                if (c.prim == 0) {
                    Pw = p + mul(Ro, pp[i]);
                    n = Rp.c0;
                    pen = -dot(Pw - po, n);
                } else {
                    Pw = po + mul(Rp, pp[i]);
                    loc = tmul(Ro, Pw - p);
                    n = Ro.c2;
                    pen = loc.z + S / 2;
                    if (fabs(loc.x) > L / 2 || fabs(loc.y) > S / 2)
                        pen = -1;
                }
                if (pen <= 0) {
                    ps[i] = {0, 0, 0};
                    continue;
                }
                V vr = v + cross(w, Pw - p);
                double vn = dot(vr, n);
                double wgt = 1;
                if (c.prim == 0) {
                    wgt = ((i % 5) % 4 == 0 ? 0.5 : 1) * ((i / 5) % 4 == 0 ? 0.5 : 1) * 25.0 / 16;
                }
                double fn = wgt * (kpi * pen - cp * vn);
                if (fn <= 0) {
                    continue;
                }
                V vt = vr - vn * n;
                double va = sqrt(dot(vt, vt));
                double smax = mup * fn / (wgt * ktp);
                V &sv_ = ps[i];
                sv_ = sv_ - dot(sv_, n) * n;
                double sm = sqrt(dot(sv_, sv_));
                double fac = va / smax * (sm / smax);
                V ds = vt - fac * sv_;
                sv_ = sv_ + dtt * ds;
                sm = sqrt(dot(sv_, sv_));
                if (sm > smax) {
                    sv_ = (smax / sm) * sv_;
                    ds = {0, 0, 0};
                }
                V fo = fn * n - (wgt * ktp) * sv_ - (wgt * 0.5 * cp) * ds;
                Fp = Fp + fo;
                Tp = Tp + cross(Pw - po, fo);
                Ft = Ft + fo;
                Tt = Tt + cross(Pw - p, fo);
            }
            if (kspr > 0 && t >= 0) {
                static V p0;
                V rel = tmul(Rg, p - gp);
                if (k <= nset || t < dtt * 0.5)
                    p0 = rel;
                V e = rel - p0;
                V fo = mul(Rg, V{-kspr * e.x, 0, -kspr * e.z});
                Ft = Ft + fo;
            }
            // sample
            if (k >= nset && (k - nset) % ns == 0) {
                V op = {p.x + nrm(3e-5), p.y + nrm(3e-5), p.z + nrm(3e-5)};
                Q oq = qn(qm(q, qrot({nrm(3e-4), nrm(3e-4), nrm(3e-4)})));
                fprintf(g, "%.6g,%g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.7g,%.7g,%.7g,%.9g,%.7g,%.7g,%.7g", t, c.grip,
                        gpr.x, gpr.y, gpr.z, gqr.w, gqr.x, gqr.y, gqr.z, op.x, op.y, op.z, oq.w, oq.x, oq.y, oq.z);
                double ch[18] = {ff[0].x, ff[0].y, ff[0].z, tt[0].x, tt[0].y, tt[0].z, ff[1].x, ff[1].y, ff[1].z,
                                 tt[1].x, tt[1].y, tt[1].z, Fp.x,    Fp.y,    Fp.z,    Tp.x,    Tp.y,    Tp.z};
                for (int i = 0; i < 18; i++) {
                    double x = ch[i];
                    if (i < 6)
                        x *= gain1;
                    double s = i < 12 ? ((i % 6) < 3 ? 0.02 : 4e-4) : ((i % 6) < 3 ? 0.04 : 1e-3);
                    fprintf(g, ",%.6g", x + ob[i] + nrm(s));
                }
                fprintf(g, "\n");
            }
            // integrate
            V acc = (1 / mass) * Ft;
            acc.z -= 9.81;
            v = v + dtt * acc;
            p = p + dtt * v;
            V wl = tmul(Ro, w), tl = tmul(Ro, Tt);
            V Iw = {I.x * wl.x, I.y * wl.y, I.z * wl.z};
            V g0 = cross(wl, Iw);
            wl = {wl.x + dtt * (tl.x - g0.x) / I.x, wl.y + dtt * (tl.y - g0.y) / I.y, wl.z + dtt * (tl.z - g0.z) / I.z};
            w = mul(Ro, wl);
            q = qn(qm(q, qrot(dtt * wl)));
            // jaw
            if (!w0set && t >= 0) {
                w00 = wj;
                w0set = true;
            }
            gl += dtt / tlag * (msl - gl);
            double G = gripF * (1 - cslip * gl);
            if (w0set)
                G += Kj * (wj - w00);
            if (lever != 0) {
                double fx = fabs(ff[0].x + ff[1].x) / 2;
                lm += dtt / 0.01 * (fx - lm);
                G -= lever * lm;
            }
            double jf = -ff[0].y + ff[1].y - 2 * G - cj * wd;
            wd += dtt * jf / mj;
            wj += dtt * wd;
            if (!(fabs(p.x) < 1)) {
                fprintf(stderr, "diverged trial %zu t=%g\n", it, t);
                return 1;
            }
        }
        fclose(g);
    }
    fclose(ft);
}
