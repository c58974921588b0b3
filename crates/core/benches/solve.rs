use rhytid_core::solve::{cholesky::Factor, dissection::dissect, driven::DrivenComponents, laplacian::laplacian, system::System};
use std::time::Instant;
fn main() {
    let path = std::env::args().nth(1).unwrap();
    let t = Instant::now();
    let rig = rhytid_core::rig_file::read(path.as_ref()).unwrap();
    println!("read {:.2}", t.elapsed().as_secs_f64());
    let rest: Vec<[f64; 3]> = rig.rest.iter().map(|p| p.map(f64::from)).collect();
    let t = Instant::now();
    let l = laplacian(&rest, &rig.triangles);
    println!("laplacian {:.2}", t.elapsed().as_secs_f64());
    let d = DrivenComponents::new(&rest, &rig.triangles, &rig.handles);
    let mut free = d.driven.clone();
    rig.handles.iter().for_each(|&v| free[v as usize] = false);
    let free: Vec<u32> = (0..rest.len() as u32).filter(|&v| free[v as usize]).collect();
    let t = Instant::now();
    let system = System::new(&l, rig.bending_length);
    println!("system {:.2}", t.elapsed().as_secs_f64());
    let t = Instant::now();
    let dis = dissect(&rest, system.pattern(), free);
    println!("dissect {:.2}", t.elapsed().as_secs_f64());
    let t = Instant::now();
    let mut place = vec![u32::MAX; rest.len()];
    for (i, &v) in dis.order.iter().enumerate() { place[v as usize] = i as u32; }
    let lower = system.lower(&dis.order, &place);
    println!("assemble {:.2}", t.elapsed().as_secs_f64());
    let t = Instant::now();
    let f = Factor::new(&lower, &dis.root, &rhytid_core::NoProgress).unwrap();
    println!("factor {:.2} {} M entries", t.elapsed().as_secs_f64(), f.entries() / 1_000_000);
    for k in [16, 23, 23] {
        let t = Instant::now();
        let blocks: Vec<usize> = (0..rig.handles.len()).step_by(k).collect();
        use rayon::prelude::*;
        blocks.par_iter().for_each(|&b| {
            let hs = &rig.handles[b..(b + k).min(rig.handles.len())];
            let k = hs.len();
            let mut x = Vec::new(); x.resize(dis.order.len() * k, 0.0);
            let mut row = Vec::new();
            for (j, &h) in hs.iter().enumerate() {
                system.row(h, &mut row);
                for (&w, value) in system.pattern().neighbors(h).iter().zip(&row) {
                    if place[w as usize] != u32::MAX { x[place[w as usize] as usize * k + j] = -value; }
                }
            }
            f.solve(&mut x, k);
        });
        println!("solves in {k} {:.2}", t.elapsed().as_secs_f64());
    }
}
