//! Steps that are not in memory: read and made ready when they are shown.

use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use mobula::accel::AccelerationKind;
use mobula::app::{self, Settings, State, Streamer};
use mobula::geometry::Particles;
use mobula::image::Size;
use mobula::light::Point;
use mobula::load::series::Gathering;
use mobula::load::{Memory, Options, load_with};
use mobula::scene::{ParticleLook, ParticleNote, SceneDescription, Steps, show_particles};

use super::Folder;

const STEPS: usize = 6;
const COUNT: usize = 300;

/// Files 0 to 5: rows of particles, further right from step to step.
fn write(folder: &Folder) {
    for step in 0..STEPS {
        let row = |i: usize| format!("{},{},0,{}\n", step * 10, i, i % 7);
        let text: String = (0..COUNT).map(row).collect();
        folder.write(&format!("a{step}.csv"), format!("x,y,z,heat\n{text}"));
    }
}

/// The scene of all files, of which those are loaded that fit into so much memory, ready to be shown.
fn scene(folder: &Folder, memory: u64) -> (SceneDescription, Vec<ParticleNote>) {
    scene_at(folder, Steps { all: true, memory, ..Steps::default() })
}

fn scene_at(folder: &Folder, steps: Steps) -> (SceneDescription, Vec<ParticleNote>) {
    let memory = steps.memory;
    let options = Options { memory: Memory::new(memory), ..Options::default() };
    let mut all = Gathering::new(&options, load_with);
    for step in 0..STEPS {
        let file = folder.0.join(format!("a{step}.csv"));
        if !all.defers(&file) {
            let loaded = load_with(&file, &options).unwrap();
            all.add(file, loaded);
        }
    }
    let [joined] = &all.join()[..] else { panic!("several series") };
    let mut scene = joined.loaded.scene.clone();
    let look = ParticleLook { radius: Some(0.5), ..ParticleLook::default() };
    let notes = show_particles(&mut scene, |_| look.clone(), steps, &AccelerationKind::Bvh.into()).unwrap();
    (scene, notes)
}

fn particles(state: &State) -> &Particles {
    state.stack.scene.geometry.list()[0].downcast_ref().unwrap()
}

/// The step that is shown, where it begins, how many particles it has, and how many steps are in memory.
type Seen = (usize, f32, u64, usize);

fn shown(state: &State) -> Seen {
    let particles = particles(state);
    let census = particles.cloud().census();
    (particles.step(), census.bounds.0.x, census.count("particles"), particles.series().in_memory().len())
}

/// Shows steps one after the other; returns what was shown, and what people were told.
fn play(scene: &SceneDescription, steps: &[usize]) -> (Vec<Seen>, Vec<String>) {
    let settings = Settings { size: Size::new(32, 24).unwrap(), threads: 2, on_demand: true, ..Settings::default() };
    let mut pipeline = app::pipeline(scene, &settings).unwrap();
    let handle = pipeline.handle();
    let told = Arc::new(Mutex::new(Vec::new()));
    let tell = Arc::clone(&told);
    let streamer =
        Streamer::start(pipeline.state(), handle.clone(), move |text| tell.lock().unwrap().push(text.into()));
    let streamer = streamer.unwrap().expect("some steps are not in memory");
    let mut seen = Vec::new();
    std::thread::scope(|scope| {
        let run = scope.spawn(|| pipeline.run_until_stopped().unwrap());
        let rendering = || handle.progress().frames > 0;
        wait(rendering);
        for &step in steps {
            streamer.show(step);
            wait(|| !streamer.waits());
            let (send, receive) = std::sync::mpsc::channel();
            handle.at_barrier("look", move |point| send.send(shown(point.state)).unwrap());
            seen.push(receive.recv().unwrap());
        }
        handle.stop();
        run.join().unwrap();
    });
    drop(streamer);
    let told = told.lock().unwrap().clone();
    (seen, told)
}

/// Waits for something. The limit is for what never comes, not for a machine that is slow.
fn wait(done: impl Fn() -> bool) {
    let start = Instant::now();
    while !done() {
        assert!(start.elapsed() < Duration::from_secs(60), "it never comes");
        std::thread::sleep(Duration::from_millis(1));
    }
}

#[test]
fn steps_are_shown_that_are_not_in_memory() {
    let folder = Folder::new("streamed");
    write(&folder);
    let (whole, _) = scene(&folder, u64::MAX);
    let all = whole.geometry[0].downcast_ref::<Particles>().unwrap();
    assert_eq!(all.series().in_memory().len(), STEPS);
    let memory = 5 * all.cloud().bytes() as u64 / 2;

    let (some, notes) = scene(&folder, memory);
    let [.., ParticleNote::NotInMemory { in_memory: 2..5, steps: STEPS, .. }] = notes[..] else { panic!("{notes:?}") };
    // Back and forth, and behind the last the first.
    let order = [0, 1, 2, 3, 4, 5, 0, 3, 1, 5];
    let (seen, told) = play(&some, &order);
    assert_eq!(told, [""; 0]);
    for (&step, (number, left, count, in_memory)) in order.iter().zip(seen) {
        assert_eq!((number, (left + 0.5).round(), count), (step, step as f32 * 10.0, COUNT as u64));
        assert!(in_memory <= 3, "{in_memory} steps of two in memory");
    }
}

#[test]
fn a_step_that_cannot_be_read_is_told_and_has_no_particles() {
    let folder = Folder::new("streamed-broken");
    write(&folder);
    let (scene, _) = scene(&folder, 1);
    folder.write("a2.csv", "x,y,z,heat\n1,2,3,4\n1,2,three,4\n");
    folder.write("a3.csv", "x,y,z\n1,2,3\n");
    std::fs::remove_file(folder.0.join("a4.csv")).unwrap();
    let (seen, told) = play(&scene, &[1, 2, 3, 4, 5]);
    let counts: Vec<_> = seen.iter().map(|(step, _, count, _)| (*step, *count)).collect();
    assert_eq!(counts, [(1, 300), (2, 0), (3, 0), (4, 0), (5, 300)]);
    for (file, problem) in
        [("a2.csv", ":3: 'three'"), ("a3.csv", ": the particles"), ("a4.csv", ": there is no such file")]
    {
        let line = told.iter().find(|line| line.contains(file)).unwrap_or_else(|| panic!("{told:?}"));
        assert!(line.contains(problem) && !line.contains('\n'), "{line}");
    }
}

#[test]
fn view_and_light_follow_from_all_steps() {
    let folder = Folder::new("streamed-view");
    write(&folder);
    let of = |shown: usize, all: bool| {
        let (scene, _) = scene_at(&folder, Steps { shown, all, ..Steps::default() });
        let built = mobula::scene::build(&scene, AccelerationKind::Bvh).unwrap();
        (built.bulk, built.view(1.5), built.lights[0].downcast_ref::<Point>().map(|light| light.position))
    };
    let first = of(0, true);
    assert_eq!(first.0.1.x.floor(), 10.0 * (STEPS - 1) as f32);
    for (shown, all) in [(3, true), (0, false), (5, false)] {
        assert_eq!(of(shown, all), first, "{shown} {all}");
    }
}
