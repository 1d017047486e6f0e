use hoverlock_fixed_point::acceptance::*;
use hoverlock_fixed_point::bounds::Bounds;
use hoverlock_fixed_point::design::KT27;
use hoverlock_fixed_point::ladder::*;
use hoverlock_reference::conditions::*;
use hoverlock_reference::maxima::is_maximum;
use hoverlock_reference::picture::Picture;
fn main() {
    let bounds = Bounds::acceptance();
    let ladder = Ladder::new(&KT27).unwrap();
    let args: Vec<String> = std::env::args().collect();
    for path in &args[1..] {
        let frame = Picture::open(path).unwrap().frame().luma;
        for c in CONDITIONS {
            for seed in [1001, 1002, 1003] {
            let f = c.apply(&frame, seed);
            let (a, b) = (ladder.planes(Rung::Streaming, &f), ladder.planes(Rung::Fixed, &f));
            let t = thresholds(&layers(&a), bounds);
            let (cmp, pair) = Comparison::between(&a, &b, bounds).unwrap();
            for k in 0..2 {
                let (mut cross, mut rival, mut moved, mut other) = (0, 0, 0, 0);
                let mut gaps = vec![];
                for (from, to, dogs) in [(&pair.reference, &pair.test, &b.dog[k]), (&pair.test, &pair.reference, &a.dog[k])] {
                    for q in from.iter().filter(|q| q.scale as usize == k) {
                        let near = to.iter().filter(|p| p.scale as usize == k).map(|p| p.x.abs_diff(q.x).max(p.y.abs_diff(q.y))).min().unwrap();
                        match near {
                            0 => {}
                            1 => moved += 1,
                            n => {
                                if is_maximum(dogs, q.x as usize, q.y as usize) && dogs[(q.x as usize, q.y as usize)] < t[k] { cross += 1; }
                                else if n <= 3 { rival += 1;
                                    // gap to best rival within window in reference
                                } else { other += 1;
                                  // is there a sub-threshold max near?
                                  let d=dogs[(q.x as usize,q.y as usize)]; gaps.push(((d-t[k])*2.0) as i32);
                                }
                            }
                        }
                    }
                }
                println!("{} {} k{k} rms {:.0} T {:.0} one {:.2} same {:.2}: moved {moved} crossed {cross} rival {rival} other {other} {gaps:?}", path.rsplit('/').next().unwrap(), c.name, cmp.scales[k].interior.reference_rms, t[k]*2.0, cmp.scales[k].kept.within_one_px_percent, cmp.scales[k].kept.same_pixel_percent);
            }}
        }
    }
}
