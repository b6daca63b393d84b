use ballrace_core::monitor::Status;
use ballrace_core::telemetry::{Kind, Message};
use parquet::record::Field;

use super::*;
use crate::fleet::store::Received;

const DAY_20: i64 = 20 * DAY_MS;

fn message(machine: &str, sequence: u32) -> Message<'_> {
    Message {
        machine,
        session: 1,
        sequence,
        model_crc: 7,
        unix_ms: 0,
        recording: 0,
        time_s: 0.5,
        status: Status::Blind,
        kind: Kind::Block,
        block: sequence + 1,
        level: f32::NAN,
        deviation: f32::NAN,
        ewma: 0.25,
        limit: 3.0,
    }
}

/// Sequence numbers, EWMA and level of a file.
fn read_back(path: &Path) -> Vec<(i64, f64, bool)> {
    let reader = SerializedFileReader::new(File::open(path).unwrap()).unwrap();
    let rows = reader.get_row_iter(None).unwrap().map(Result::unwrap);
    rows.map(|row| {
        let field = |name: &str| row.get_column_iter().find(|(column, _)| *column == name).unwrap().1.clone();
        match (field("sequence"), field("ewma"), field("level")) {
            (Field::Long(sequence), Field::Double(ewma), level) => (sequence, ewma, level == Field::Null),
            found => panic!("{found:?}"),
        }
    })
    .collect()
}

#[test]
fn invariant_a_partition_is_what_the_store_has_whatever_was_lost_of_the_folder() {
    let folder = tempfile::tempdir().unwrap();
    let mut store = Store::open(&folder.path().join("fleet.sqlite")).unwrap();
    let parts = folder.path().join("parts");
    let take = |store: &mut Store, machine, sequence, at| {
        store.take(&[Received::Message(message(machine, sequence))], at).unwrap();
    };
    take(&mut store, "pump", 0, DAY_20 - 1);
    take(&mut store, "pump", 1, DAY_20);
    take(&mut store, "a b=%", 0, DAY_20);
    let mut partitions = Partitions::open(&parts, &store).unwrap();
    partitions.write(&store, usize::MAX).unwrap();
    assert!(partitions.is_current());
    let file = format!("{}.parquet", store.client_id().unwrap());
    let path = |partition: &str| parts.join(partition).join(&file);
    let (old, new) = (path("machine=pump/day=1970-01-20"), path("machine=pump/day=1970-01-21"));
    assert_eq!(read_back(&old), [(0, 0.25, true)]);
    assert_eq!(read_back(&new), [(1, 0.25, true)]);
    assert_eq!(read_back(&path("machine=a%20b%3D%25/day=1970-01-21")).len(), 1);
    assert!(Partitions::open(&parts, &store).unwrap().is_current());

    // A message more, a file that was cut short and one that is gone: a collector that starts finds all three.
    take(&mut store, "pump", 2, DAY_20 + 5);
    fs::write(&old, &fs::read(&old).unwrap()[..100]).unwrap();
    fs::remove_dir_all(parts.join("machine=a%20b%3D%25")).unwrap();
    let mut partitions = Partitions::open(&parts, &store).unwrap();
    assert_eq!(partitions.stale.len(), 3);
    partitions.write(&store, 2).unwrap();
    assert_eq!(partitions.stale.len(), 1);
    partitions.write(&store, usize::MAX).unwrap();
    assert_eq!(read_back(&new), [(1, 0.25, true), (2, 0.25, true)]);
    assert_eq!(read_back(&old), [(0, 0.25, true)]);

    // A duplicate on a later day makes no file.
    take(&mut store, "pump", 2, DAY_20 + DAY_MS);
    partitions.note("pump", DAY_20 + DAY_MS);
    partitions.write(&store, usize::MAX).unwrap();
    assert!(!path("machine=pump/day=1970-01-22").exists() && partitions.is_current());
}
