use std::time::Instant;
use stickslip_host::lcp_files::*;
use stickslip_shared::lcp::{
    contact::*,
    factors::{Contact, Factors as F},
    *,
};
fn conv<const ND: usize>(p: &Factors) -> F<f64, 16, ND> {
    let nc = p.friction.len();
    let nd = p.inverse_mass.len();
    let mut f = F { inverse_mass: [0.0; ND], contacts: Default::default() };
    f.inverse_mass[..nd].copy_from_slice(&p.inverse_mass);
    for i in 0..nc {
        let row = |r: usize| {
            let mut a = [0.0; ND];
            a[..nd].copy_from_slice(&p.jacobian[r * nd..(r + 1) * nd]);
            a
        };
        f.contacts
            .push(Contact {
                normal: row(i),
                tangents: [row(nc + 4 * i), row(nc + 4 * i + 1)],
                compliance: p.compliance[i],
                friction: p.friction[i],
                separation: p.constant[i],
                slip: [p.constant[nc + 4 * i], p.constant[nc + 4 * i + 1]],
            })
            .unwrap();
    }
    f
}
fn run<const ND: usize>(name: &str, s: &FactorSet, shift: f64) -> (usize, usize) {
    let mut sol = ContactSolver::<f64, 16, ND>::new();
    let _ = shift;
    let (mut cold, mut warm) = (vec![], vec![]);
    let mut ok = 0;
    let mut piv = vec![];
    let mut worst = 0f64;
    let mut resid = vec![];
    for p in s.problems.iter().skip(std::env::var("SKIP").map(|x| x.parse().unwrap()).unwrap_or(0)) {
        let f = conv::<ND>(p);
        let mut t = vec![];
        for _ in 0..reps() {
            sol.forget();
            let a = Instant::now();
            let o = sol.solve(&f);
            std::hint::black_box(o.report());
            t.push(a.elapsed().as_nanos() as f64 / 1e3);
        }
        t.sort_by(f64::total_cmp);
        cold.push(t[4]);
        sol.forget();
        let (r, z) = {
            let o = sol.solve(&f);
            let mut z = vec![0.0; f.unknowns()];
            o.best().0.write_unknowns(&mut z);
            (o.report(), z)
        };
        let e = f.residual(&z).value();
        worst = worst.max(e);
        piv.push(r.pivots);
        resid.push((r.residual * 1e12).round() / 1e12);
        if r.status == Status::Solved && e <= 1e-8 {
            ok += 1;
        } else if r.status == Status::Solved {
            println!("FALSE {e} {r:?}")
        }
        if r.status != Status::Solved && std::env::var("V").is_ok() {
            println!("   done {:?} exact {:.1e}", r, e);
        }
        let mut t = vec![];
        for _ in 0..reps() {
            let a = Instant::now();
            let o = sol.solve(&f);
            std::hint::black_box(o.report());
            t.push(a.elapsed().as_nanos() as f64 / 1e3);
        }
        t.sort_by(f64::total_cmp);
        warm.push(t[4]);
    }
    cold.sort_by(f64::total_cmp);
    warm.sort_by(f64::total_cmp);
    let n = cold.len();
    println!(
        "{:22} ok {}/{} worst {:.1e} cold {:.2} p99 {:.2} warm {:.2} max {:.2} piv {:?}",
        name,
        ok,
        n,
        worst,
        cold[n / 2],
        cold[n * 99 / 100],
        warm[n / 2],
        warm[n - 1],
        &piv[..piv.len().min(6)]
    );
    (ok, n)
}
fn main() {
    let shift: f64 = std::env::var("SHIFT").ok().and_then(|x| x.parse().ok()).unwrap_or(1e-7);
    let (mut a, mut b) = (0, 0);
    for f in std::env::args().skip(1) {
        if let ProblemFile::Factors(s) = read(f.as_ref()).unwrap() {
            let nm = f.rsplit('/').next().unwrap();
            let (x, y) = if s.freedoms <= 6 { run::<6>(nm, &s, shift) } else { run::<8>(nm, &s, shift) };
            a += x;
            b += y;
        }
    }
    println!("ok {a}/{b}");
}

fn reps() -> usize {
    std::env::var("REPS").map(|x| x.parse().unwrap()).unwrap_or(9)
}
