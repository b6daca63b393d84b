//! [`Model::from_bytes`] on arbitrary bytes, and the device with every model that passes.
//!
//! Few mutations keep a checksum right, so it and the words before it that are no content are put right first, unless the
//! first byte says otherwise.
#![no_main]

use ballrace_core::crc::crc32;
use ballrace_core::model::{MAGIC, Model};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| {
    let Some((how, rest)) = data.split_first() else { return };
    if how % 8 == 0 {
        let _ = Model::from_bytes(rest);
        return;
    }
    let mut bytes = rest.to_vec();
    bytes.truncate(rest.len() / 4 * 4);
    if bytes.len() < 16 {
        return;
    }
    let (words, crc_at) = (bytes.len() as u32 / 4, bytes.len() - 4);
    bytes[..4].copy_from_slice(&MAGIC);
    bytes[8..12].copy_from_slice(&words.to_le_bytes());
    let crc = crc32(&bytes[..crc_at]);
    bytes[crc_at..].copy_from_slice(&crc.to_le_bytes());
    if let Ok(model) = Model::from_bytes(&bytes) {
        // What is read is written as the same model: to the bit, since it may hold NaN where no check forbids it.
        let mut again = vec![0; model.byte_len()];
        model.to_bytes(&mut again).unwrap();
        let reread = Model::from_bytes(&again).unwrap();
        let mut third = vec![0; reread.byte_len()];
        reread.to_bytes(&mut third).unwrap();
        assert_eq!(again, third);
        ballrace_core_fuzz::run(&model, rest);
    }
});
