//! The step with friction pyramids.
#[path = "common/grasps.rs"]
mod grasps;

use grasps::*;
use stickslip_shared::cone;
use stickslip_shared::lcp::step::{self, PyramidParams};
use stickslip_shared::solve::*;

#[test]
fn explore() {
    for mu in [0.5, 3.0] {
        for edges in [4, 8, 16] {
            let params = PyramidParams { edges, ..PyramidParams::default() };
            let p32 = PyramidParams { edges, ..PyramidParams::default() };
            let mut draw = Draw(99);
            let (mut solved, mut solved32, mut it, mut ev, mut coned) = (0, 0, 0, 0, 0);
            let mut worst = 0.0f64;
            let mut cone_ev = 0;
            let n = 400;
            for case in 0..n {
                let push = if case % 2 == 0 { Push::Plane } else { Push::Edge };
                let (points, bodies) = random_grasp(&mut draw, push, mu, 1e7);
                let a = cone::solve(&points, &bodies, &[0.0; 7], &SolveBudget::default());
                let b = step::solve(&points, &bodies, &[0.0; 7], &SolveBudget::default(), &params);
                let (pn, bn) = narrow(&points, &bodies);
                let c = step::solve(&pn, &bn, &[0.0; 7], &SolveBudget::present(), &p32);
                coned += u32::from(a.status == SolveStatus::Solved);
                solved += u32::from(b.status == SolveStatus::Solved);
                solved32 += u32::from(c.status == SolveStatus::Solved);
                it += b.iterations;
                ev += b.evaluations;
                cone_ev += a.evaluations + 4 * a.iterations;
                if a.status == SolveStatus::Solved && b.status == SolveStatus::Solved {
                    let sum = |f: &[[f64; 3]]| f.iter().map(|f| f[1].hypot(f[2])).sum::<f64>();
                    let (x, y) = (sum(&a.force_n), sum(&b.force_n));
                    worst = worst.max((x - y).abs() / x.max(1.0));
                }
            }
            println!("mu {mu} edges {edges}: cone {coned} lcp {solved} f32 present {solved32} of {n}; it {:.1} ev {:.1} (cone work {:.1}) worst {worst:.3}", f64::from(it)/n as f64, f64::from(ev)/n as f64, f64::from(cone_ev)/n as f64);
        }
    }
}
