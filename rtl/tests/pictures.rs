//! Real pictures at 1024 x 768 through the hardware, with and without pauses.

use hoverlock_reference::picture::{Picture, data_dir};
use hoverlock_rtl::simulation::{Job, Simulator, Streams, run};

#[test]
#[ignore = "long: five real pictures, seeds 1 to 5"]
fn real_pictures_are_exact_with_and_without_pauses() {
    let Some(folder) = data_dir() else {
        eprintln!("skipped: no folder of pictures; set HOVERLOCK_DATA");
        return;
    };
    let simulator = Simulator::new().unwrap();
    let names = ["dirt_road", "farmstead", "lake_shore", "pasture_low_texture", "urban_intersection_a"];
    for (name, seed) in names.iter().zip(1..) {
        let picture = Picture::open(folder.join(format!("textures/{name}.png"))).unwrap();
        let jobs = vec![Job::new(picture.frame().luma, [60, 60]).unwrap(); 3];
        for stall in [0.0, 0.4] {
            let frames = if stall == 0.0 { &jobs[..] } else { &jobs[..1] };
            let streams = Streams { source_pause: stall, sink_pause: stall, seed, ..Streams::default() };
            let outcome = run(&simulator, frames, streams).unwrap();
            assert!(outcome.pass(), "{name}, stall {stall}, seed {seed}: {outcome:#?}");
            if stall == 0.0 {
                assert_eq!(outcome.cycles_per_pixel, Some(1.0), "{name}");
            }
            eprintln!(
                "{name}, stall {stall}: {} features, {:.0} cycles/s",
                outcome.features, outcome.cycles_per_second
            );
        }
    }
}
