use stickslip_host::lcp_gen::*;
use stickslip_shared::lcp::{contact::*, *};
fn main() {
    let n: u64 = std::env::args().nth(1).unwrap().parse().unwrap();
    let s0: u64 = std::env::args().nth(2).map(|x| x.parse().unwrap()).unwrap_or(0);
    let mut sol = ContactSolver::<f64, 16, 8>::new();
    for fam in FAMILIES {
        let (mut ok, mut falses, mut t, mut maxp, mut worst) = (0, 0, vec![], 0, 0f64);
        let mut st = std::collections::BTreeMap::new();
        for s in 0..n {
            let nc = [2, 6, 9, 10][(s % 4) as usize];
            let p = contact_problem(fam, nc, s0 + s);
            let Some(f) = to_problem::<16, 8>(&p) else { panic!() };
            sol.forget();
            let a = std::time::Instant::now();
            let o = sol.solve(&f);
            let dt = a.elapsed().as_nanos() as f64 / 1e3;
            if nc == 10 {
                t.push(dt);
            }
            let (imp, r) = o.best();
            let mut z = vec![0.0; f.unknowns()];
            imp.write_unknowns(&mut z);
            maxp = maxp.max(r.pivots);
            let e = if r.status == Status::Solved { f.residual(&z).value() } else { 0.0 };
            *st.entry(format!("{:?}/{:?}", r.status, r.path)).or_insert(0) += 1;
            if r.status == Status::Solved {
                if e <= 1e-8 {
                    ok += 1;
                    worst = worst.max(e)
                } else {
                    falses += 1;
                    println!("FALSE {fam:?} {nc} {s} {e:e} {r:?}")
                }
            } else if std::env::var("V").is_ok() {
                println!("  {fam:?} {nc} {s} {r:?}")
            }
        }
        t.sort_by(f64::total_cmp);
        println!(
            "{fam:?} ok {ok}/{n} false {falses} worst {worst:.1e} med {:.1} p99 {:.1} max {:.1} maxpiv {maxp} {st:?}",
            t[t.len() / 2],
            t[t.len() * 99 / 100],
            t[t.len() - 1]
        );
    }
}
