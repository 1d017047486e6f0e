//! Scene files: the built-in ones are valid, and errors are reported with their line.

use std::path::Path;

use hoverlock_edss::render::Renderer;
use hoverlock_edss::scene::Scene;
use nalgebra::Vector2;

fn refusal(text: &str) -> String {
    match Scene::parse(text, Path::new("nowhere")) {
        Ok(_) => panic!("taken: {text}"),
        Err(error) => error.to_string(),
    }
}

#[test]
fn scenes_that_come_with_the_simulator_are_sound() {
    for name in Scene::NAMES {
        let text = Scene::named(name).unwrap();
        match Scene::parse(text, Path::new("")) {
            Ok(scene) => drop(Renderer::new(&scene, 1).unwrap()),
            // The photograph is fetched by `make demo`; without it the error says so.
            Err(error) if name == "aerial" => {
                eprintln!("skipped: scene {name} {error}");
                assert!(error.to_string().contains("make demo"), "{error}");
            }
            Err(error) => panic!("scene {name} {error}"),
        }
    }
    assert!(Scene::named("moon").is_none());
}

#[test]
fn what_is_wrong_is_refused_by_line() {
    let cases = [
        (
            "[ground.grass]\n\n[sun]\nazimuth_deg = 10\nelevation = 30\n",
            "line 5: sun.elevation: unknown field `elevation`",
        ),
        ("[ground.grass]\nbrightnes = 1\n", "line 2: ground.grass.brightnes: unknown field"),
        ("brightness = \"high\"\n[ground.grass]\n", "line 1: brightness: invalid type: string \"high\""),
        ("[ground.lava]\n", "line 1: ground.lava: unknown variant `lava`, expected one of `picture`, `field`"),
        ("brightness = 1.0\n", "line 1: missing field `ground`"),
        (
            "[ground.grass]\n[mist]\nextinction_per_m = -0.1\n",
            "line 3: mist.extinction_per_m: -0.1 is out of range: 0 to 1",
        ),
        ("[ground.grass]\n[mist]\nextinction_per_m = 3\n", "line 3: mist.extinction_per_m: 3 is out of range: 0 to 1"),
        ("[ground.grass]\n[mist]\nextinction_per_m = nan\n", "line 3: mist.extinction_per_m: NaN is out of range"),
        ("[ground.field]\nparcel_m = 5.0\n", "line 2: ground.field.parcel_m: 5 is out of range: 10 to 100"),
        (
            "[ground.grass]\n[[tree]]\nat_m = [0, 0]\nradius_m = 2\nheight_m = 5\n\
             [[tree]]\nat_m = [0, 0]\nradius_m = 0\nheight_m = 5\n",
            "line 8: tree.1.radius_m: 0 is out of range: 0.1 to 20",
        ),
        (
            "[ground.grass]\n[[car]]\nfrom_m = [1, 1]\nto_m = [1, 1]\nspeed_m_per_s = 3\n",
            "line 4: car.0.to_m: must differ from from_m",
        ),
        (
            "[ground.picture]\ntexel_m = 0.1\nfile = \"none.png\"\n",
            "line 3: ground.picture.file: none.png is neither in nowhere nor among the photographs that `make demo`",
        ),
        ("[ground.grass]\nthis is not TOML\n", "line 2: "),
        (
            "[ground.grass]\n[[building]]\nat_m = [1, 2]\nsize_m = [3, 4, 5]\nheight_m = 2\n",
            "line 4: building.0.size_m: invalid length 3, expected an array of length 2",
        ),
        ("sun = [300, 45]\n[ground.grass]\n", "line 1: sun: invalid type: sequence, expected struct Sun"),
        ("[ground.grass]\n[relief.hills]\nrms_m = 3\n", "line 2: relief.hills: missing field `wavelength_m`"),
    ];
    for (text, expected) in cases {
        let found = refusal(text);
        assert!(found.starts_with(expected), "{found}\nexpected {expected}");
        assert!(!found.contains('\n'), "{found}");
    }
}

#[test]
fn a_map_of_heights_has_two_columns_and_rows_and_a_sun_has_defaults() {
    let folder = tempfile::tempdir().unwrap();
    let scene = |columns: usize| {
        let samples = vec![b'1'; columns];
        let head = format!("P5\n{columns} 2\n255\n");
        std::fs::write(folder.path().join("map.pgm"), [head.as_bytes(), &samples, &samples].concat()).unwrap();
        let text =
            "[ground.grass]\n[sun]\nelevation_deg = 30\n[relief.map]\nfile = \"map.pgm\"\ntexel_m = 1\nheight_m = 9\n";
        Scene::parse(text, folder.path())
    };
    let refused = scene(1).unwrap_err().to_string();
    assert!(refused.starts_with("line 5: relief.map.file: ") && refused.contains("at least 2 x 2"), "{refused}");
    let renderer = Renderer::new(&scene(2).unwrap(), 1).unwrap();
    assert_eq!(renderer.surface(0.0, Vector2::new(3.0, -4.0)), 0.0);
}

#[test]
fn the_surface_is_that_of_roofs_and_hills() {
    let text = "[ground.grass]\n[[building]]\nat_m = [5, 0]\nsize_m = [4, 4]\nheight_m = 7\n";
    let renderer = Renderer::new(&Scene::parse(text, Path::new("")).unwrap(), 1).unwrap();
    let heights = [[5.0, 0.0], [6.9, 1.9], [7.1, 0.0]].map(|[x, y]| renderer.surface(0.0, Vector2::new(x, y)));
    assert!(heights.iter().zip([7.0, 7.0, 0.0]).all(|(found, height)| (found - height).abs() < 1e-3), "{heights:?}");
}

#[test]
fn a_relief_that_hides_ground_is_refused() {
    let text = "[ground.grass]\n[relief.hills]\nrms_m = 30\nwavelength_m = 50\n";
    let scene = Scene::parse(text, Path::new("")).unwrap();
    let error = Renderer::new(&scene, 1).map(drop).unwrap_err().to_string();
    assert!(error.contains("too steep"), "{error}");
}
