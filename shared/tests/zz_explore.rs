mod common;
use common::*;
use stickslip_shared::model::Formulation;
#[test]
fn series() {
    let run = |by| {
        let mut v = Vec::new();
        let mut k = 0;
        linear_push::<f64>(hard_by(by, 0.15, 0.25, 0.0), 20.0, 0.010, 0.0, 1.5, |s| {
            v.push((s.state.velocity, s.out.iterations, s.out.evaluations, s.out.solved_by, s.out.force_n.first().map(|f| f[2]/f[1]).unwrap_or(0.0), s.state.position_m.z, s.out.force_n[2][1]/s.out.force_n[2][2], s.state.velocity[4]));
            k += 1;
        });
        v
    };
    let (a, b) = (run(Formulation::Cone), run(Formulation::Lcp));
    for k in (8..40).chain((40..375).step_by(15)) {
        println!("{k} cone vz/vx {:.4} w {:.4} z {:.6} | lcp {:.4} w {:.4} z {:.6} it {} ev {} {:?}", a[k].0[2]/a[k].0[0], a[k].7, a[k].5, b[k].0[2]/b[k].0[0], b[k].7, b[k].5, b[k].1, b[k].2, b[k].3);
    }
}
