//! Real pictures at 1024 x 768 through the hardware, back to back, with and without pauses.

use hoverlock_pictures::{Picture, data_dir};
use hoverlock_simulation::{Job, Simulator, Streams, run};

#[test]
#[ignore = "long: five real pictures, six times, 30 million cycles"]
fn real_pictures_are_exact_with_and_without_pauses() {
    let Some(folder) = data_dir() else {
        eprintln!("skipped: no folder of pictures; set HOVERLOCK_DATA");
        return;
    };
    let simulator = Simulator::new().unwrap();
    let names = ["dirt_road", "farmstead", "lake_shore", "pasture_low_texture", "urban_intersection_a"];
    let jobs = names.map(|name| {
        let picture = Picture::open(folder.join(format!("textures/{name}.png"))).unwrap();
        Job::new(picture.crop(1024, 768).luma, [60, 60]).unwrap()
    });
    // Without pauses a seed changes nothing.
    for (stall, seeds) in [(0.0, 1..=1), (0.4, 1..=5)] {
        for seed in seeds {
            let streams = Streams { source_pause: stall, sink_pause: stall, seed, ..Streams::default() };
            let outcome = run(&simulator, &jobs, streams).unwrap();
            assert!(outcome.pass(), "stall {stall}, seed {seed}: {outcome:#?}");
            assert_eq!(outcome.cycles_per_pixel, (stall == 0.0).then_some(1.0), "seed {seed}");
            for (name, frame) in names.iter().zip(&outcome.frames) {
                assert!(frame.features > 0, "{name}");
            }
            eprintln!(
                "stall {stall}, seed {seed}: {} features, {:.2} million cycles a second",
                outcome.features,
                outcome.cycles_per_second / 1e6
            );
        }
    }
}
