//! Recordings: what is written reads back in both formats, files are cut off, disks are full, files follow one another.

use std::fs;
use std::path::Path;

use palpate::Sample;
use palpate::palms::PalmPair;
use palpate::pivot::{PivotRig, PivotSample};
use palpate_live::{RecordError, Recorder, RigKind, Rotation, mcap_rig_kind, read_mcap_log, read_mcap_strokes};

fn samples(count: usize) -> Vec<Sample> {
    let sample = |index: usize| {
        let time_s = 0.01 * index as f64;
        Sample {
            s2_m: (!index.is_multiple_of(7)).then_some(0.04 + time_s / 300.0),
            force1_n: (index.is_multiple_of(2)).then_some(1.0 / 3.0),
            ..Sample::new(time_s, PalmPair::hinged(1.0 + time_s / 7.0, 1.3), 0.03, 0.0)
        }
    };
    (0..count).map(sample).collect()
}

fn metadata() -> Vec<(String, String)> {
    vec![("rig".to_owned(), "exact".to_owned())]
}

fn read(path: &Path) -> Vec<Sample> {
    let (file, rig) = if path.extension().is_some_and(|extension| extension == "mcap") {
        read_mcap_log(path, None, None).unwrap_or_else(|error| panic!("{error}"))
    } else {
        palpate_io::read_log_with_rig(path).unwrap_or_else(|error| panic!("{error}"))
    };
    assert_eq!(rig, Some(palpate_io::RigFile::exact()));
    file.log.samples
}

#[test]
fn what_is_recorded_reads_back_the_same_in_both_formats() {
    let dir = tempfile::tempdir().expect("a folder");
    for name in ["new folder/log.csv", "log.mcap"] {
        let path = dir.path().join(name);
        let mut recorder = Recorder::create(&path, Rotation::default(), &metadata()).expect("a recording");
        samples(1000).chunks(7).for_each(|part| recorder.push(part).expect("a disk with room"));
        let recorded = recorder.finish().expect("an end");
        assert_eq!((recorded.samples, &recorded.files[..]), (1000, std::slice::from_ref(&path)));
        assert_eq!(read(&path), samples(1000), "{name}");
        let again = Recorder::<Sample>::create(&path, Rotation::default(), &metadata()).map(|_| ());
        assert!(matches!(again, Err(RecordError::Exists { .. })), "{again:?}");
    }
    let other = Recorder::<Sample>::create(&dir.path().join("log.txt"), Rotation::default(), &metadata()).map(|_| ());
    assert!(matches!(other, Err(RecordError::Format { .. })), "{other:?}");
}

#[test]
fn strokes_that_are_recorded_read_back_the_same_in_both_formats() {
    let dir = tempfile::tempdir().expect("a folder");
    let sample = |index: usize| {
        let time_s = 0.05 * index as f64;
        let s_m = (!index.is_multiple_of(7)).then_some(0.5 + time_s / 300.0);
        PivotSample { time_s, pivot_x_m: 0.5 + time_s / 7.0, pivot_y_m: 0.1 / 3.0, s_m }
    };
    let samples: Vec<PivotSample> = (0..300).map(sample).collect();
    let metadata = [metadata(), vec![("swing_period_s".to_owned(), "0.4".to_owned())]].concat();
    for name in ["strokes.csv", "strokes.mcap"] {
        let path = dir.path().join(name);
        let mut recorder = Recorder::create(&path, Rotation::default(), &metadata).expect("a recording");
        samples.chunks(7).for_each(|part| recorder.push(part).expect("a disk with room"));
        recorder.finish().expect("an end");
        let read = |path: &Path| {
            let file = if name.ends_with("mcap") {
                assert_eq!(mcap_rig_kind(path, None), RigKind::Pivot);
                read_mcap_strokes(path, None).map_err(|error| error.to_string())
            } else {
                palpate_io::read_strokes(path).map_err(|error| error.to_string())
            };
            file.unwrap_or_else(|error| panic!("{error}"))
        };
        let file = read(&path);
        assert_eq!((file.rig, file.log.swing_period_s), (Some(PivotRig::default()), Some(0.4)), "{name}");
        assert_eq!(file.log.samples, samples, "{name}");
        let bytes = fs::read(&path).expect("the file");
        fs::write(&path, &bytes[..bytes.len() - 30]).expect("a shorter file");
        let cut = read(&path);
        assert!(cut.log.samples == samples[..cut.log.samples.len()] && cut.notes.len() <= 2, "{name}: {:?}", cut.notes);
    }
    let palms = dir.path().join("palms.mcap");
    let mut recorder = Recorder::create(&palms, Rotation::default(), &metadata).expect("a recording");
    recorder.push(&self::samples(20)).expect("a disk with room");
    recorder.finish().expect("an end");
    assert_eq!(mcap_rig_kind(&palms, None), RigKind::Palms);
    assert!(
        read_mcap_strokes(&palms, None).is_err()
            && read_mcap_log(&dir.path().join("strokes.mcap"), None, None).is_err()
    );
}

#[test]
fn a_recording_that_is_cut_off_anywhere_reads_up_to_there() {
    let dir = tempfile::tempdir().expect("a folder");
    for name in ["log.csv", "log.mcap"] {
        let path = dir.path().join(name);
        let mut recorder = Recorder::create(&path, Rotation::default(), &metadata()).expect("a recording");
        for part in samples(200).chunks(10) {
            recorder.push(part).expect("a disk with room");
            recorder.hand_over().expect("a disk with room");
        }
        recorder.finish().expect("an end");
        let bytes = fs::read(&path).expect("the file");
        let mut before = 0;
        for end in (bytes.len() / 2..bytes.len()).step_by(97) {
            fs::write(&path, &bytes[..end]).expect("a shorter file");
            let found = read(&path);
            assert!(found.len() >= before && found == samples(200)[..found.len()], "{name}, {end} of {}", bytes.len());
            before = found.len();
        }
        assert!(before >= 190, "{name}: {before}");
    }
}

#[test]
fn files_follow_one_another_by_time_and_by_size() {
    let dir = tempfile::tempdir().expect("a folder");
    for (name, rotation) in [
        ("time.csv", Rotation { size_bytes: None, duration_s: Some(2.5) }),
        ("time.mcap", Rotation { size_bytes: None, duration_s: Some(2.5) }),
        ("size.csv", Rotation { size_bytes: Some(20_000), duration_s: None }),
    ] {
        let mut recorder = Recorder::create(&dir.path().join(name), rotation, &metadata()).expect("a recording");
        recorder.push(&samples(1000)).expect("a disk with room");
        let recorded = recorder.finish().expect("an end");
        assert!(recorded.files.len() >= 4, "{recorded:?}");
        assert!(recorded.files[1].display().to_string().contains(".0002."), "{recorded:?}");
        let all: Vec<Sample> = recorded.files.iter().flat_map(|file| read(file)).collect();
        assert_eq!(all, samples(1000), "{name}");
        let sizes = recorded.files.iter().map(|file| fs::metadata(file).expect("a file").len());
        assert!(name.starts_with("time") || sizes.max() < Some(21_000));
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_a_failure_that_says_so() {
    let error = Recorder::<Sample>::create(Path::new("/dev/full"), Rotation::default(), &metadata()).map(|_| ());
    let Err(RecordError::Io { file, kind, .. }) = error else { panic!("{error:?}") };
    assert_eq!((file.as_str(), kind), ("/dev/full", std::io::ErrorKind::StorageFull));
}
