use stickslip_host::lcp_gen::*;
use stickslip_shared::lcp::{contact::*, dense::Dense, factors::*, *};
fn single(p: &Factors<f64, 64, 8>) -> Factors<f32, 64, 8> {
    let mut l = heapless::Vec::new();
    for c in &p.contacts {
        let _ = l.push(Contact {
            normal: c.normal.map(|x| x as f32),
            tangents: c.tangents.map(|t| t.map(|x| x as f32)),
            compliance: c.compliance as f32,
            friction: c.friction as f32,
            separation: c.separation as f32,
            slip: c.slip.map(|x| x as f32),
        });
    }
    Factors { inverse_mass: p.inverse_mass.map(|x| x as f32), contacts: l }
}
fn main() {
    let n: u64 = std::env::args().nth(1).unwrap().parse().unwrap();
    let mut s64 = Box::new(ContactSolver::<f64, 64, 8>::new());
    let mut s32 = Box::new(ContactSolver::<f32, 64, 8>::new());
    let mut d = Box::new(Dense::<f64, 64>::new());
    println!("f32");
    for fam in FAMILIES {
        let (mut ok, mut worst) = (0, 0f64);
        let mut dv = vec![];
        let mut st = std::collections::BTreeMap::new();
        for s in 0..n {
            let nc = [2, 6, 9, 10][(s % 4) as usize];
            let f = to_problem::<64, 8>(&contact_problem(fam, nc, s)).unwrap();
            let g = single(&f);
            s64.forget();
            s32.forget();
            let a = s64.solve(&f).best().0.velocity_change;
            let o = s32.solve(&g);
            let (i, r) = o.best();
            *st.entry(format!("{:?}", r.status)).or_insert(0) += 1;
            let mut z = vec![0f32; f.unknowns()];
            i.write_unknowns(&mut z);
            let z64: Vec<f64> = z.iter().map(|x| *x as f64).collect();
            let e = f.residual(&z64).value();
            if r.status == Status::Solved {
                ok += 1;
                worst = worst.max(e);
                dv.push((0..3).map(|k| (i.velocity_change[k] as f64 - a[k]).abs()).fold(0.0, f64::max));
            }
        }
        dv.sort_by(f64::total_cmp);
        let q = |k: usize| dv.get(dv.len() * k / 100).copied().unwrap_or(f64::NAN);
        println!(
            "{fam:?} solved {ok}/{n} worst64 {worst:.1e} velocity error m/s median {:.1e} p99 {:.1e} {st:?}",
            q(50),
            q(99)
        );
    }
    println!("contacts cold warm");
    for nc in [4, 8, 16, 32, 64] {
        let (mut t, mut w, mut p) = (vec![], vec![], vec![]);
        for s in 0..100 {
            let fa = contact_problem(Family::Force, nc, s);
            let f = to_problem::<64, 8>(&fa).unwrap();
            let g = to_problem::<64, 8>(&neighbour(&fa, 1e-4, s)).unwrap();
            let mut b = 1e9f64;
            for _ in 0..5 {
                s64.forget();
                let a = std::time::Instant::now();
                p.push(s64.solve(&f).report().pivots);
                b = b.min(a.elapsed().as_nanos() as f64 / 1e3);
            }
            t.push(b);
            let keep = s64.clone();
            let mut b = 1e9f64;
            for _ in 0..5 {
                s64.clone_from(&keep);
                let a = std::time::Instant::now();
                std::hint::black_box(s64.solve(&g).report());
                b = b.min(a.elapsed().as_nanos() as f64 / 1e3);
            }
            w.push(b);
        }
        t.sort_by(f64::total_cmp);
        w.sort_by(f64::total_cmp);
        p.sort();
        println!("{nc} cold {:.2} warm {:.2} pivots {}", t[50], w[50], p[250]);
    }
    println!("warm at 10 contacts by change");
    for ch in [0.0, 1e-5, 1e-4, 1e-3, 1e-2] {
        let mut w = vec![];
        let mut same = 0;
        for s in 0..200 {
            let fa = contact_problem(if s % 2 == 0 { Family::Force } else { Family::Approach }, 10, s);
            let f = to_problem::<64, 8>(&fa).unwrap();
            let g = to_problem::<64, 8>(&neighbour(&fa, ch, s)).unwrap();
            s64.forget();
            let _ = s64.solve(&f).report();
            let keep = s64.clone();
            let mut b = 1e9f64;
            for _ in 0..5 {
                s64.clone_from(&keep);
                let a = std::time::Instant::now();
                let r = s64.solve(&g).report();
                same += (r.path == Path::Warm) as usize;
                b = b.min(a.elapsed().as_nanos() as f64 / 1e3);
            }
            w.push(b);
        }
        w.sort_by(f64::total_cmp);
        println!("{ch} {:.2} p99 {:.2} same {}/1000", w[100], w[198], same);
    }
    println!("dense");
    for fam in FAMILIES {
        let mut h = std::collections::BTreeMap::new();
        for s in 0..n.min(500) {
            let (m, q) = contact_problem(fam, [2, 6, 9, 10][(s % 4) as usize], s).dense();
            let r = d.solve(&m, &q).report();
            *h.entry(format!("{:?} {:?}", r.status, r.path)).or_insert(0) += 1;
        }
        println!("{fam:?} {h:?}");
    }
}
