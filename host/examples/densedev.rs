use stickslip_host::lcp_gen::*;
use stickslip_shared::lcp::{dense::Dense, *};
fn main() {
    let n: u64 = std::env::args().nth(1).unwrap().parse().unwrap();
    let mut d = Box::new(Dense::<f64, 64>::new());
    for fam in FAMILIES {
        let mut h = std::collections::BTreeMap::new();
        for s in 0..n {
            let p = contact_problem(fam, [2, 6, 9, 10][(s % 4) as usize], s);
            let (m, q) = p.dense();
            let r = d.solve(&m, &q).report();
            *h.entry(format!("{:?} {:?}", r.status, r.path)).or_insert(0) += 1;
            if r.status != Status::Solved {
                println!("{fam:?} {s} {r:?}")
            }
        }
        println!("{fam:?} {h:?}");
    }
}
