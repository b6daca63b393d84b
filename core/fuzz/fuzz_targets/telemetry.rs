//! [`Message::decode`] on arbitrary bytes; what passes is written again as the same bytes, and cut short it is refused.
//!
//! Length, magic, version and checksum are put right first, but where the first byte is a multiple of 8.
#![no_main]

use ballrace_core::crc::crc32;
use ballrace_core::telemetry::{FORMAT_VERSION, MAGIC, MESSAGE_LEN, Message, is_name};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| {
    let Some((how, rest)) = data.split_first() else { return };
    let mut bytes = rest.to_vec();
    if how % 8 != 0 {
        bytes.resize(MESSAGE_LEN, 0);
        bytes[..4].copy_from_slice(&MAGIC);
        bytes[4] = FORMAT_VERSION;
        let crc = crc32(&bytes[..MESSAGE_LEN - 4]);
        bytes[MESSAGE_LEN - 4..].copy_from_slice(&crc.to_le_bytes());
    }
    let Ok(message) = Message::decode(&bytes) else { return };
    assert!(is_name(message.machine));
    let mut again = [0; MESSAGE_LEN];
    assert_eq!(message.encode(&mut again), Ok(MESSAGE_LEN));
    assert_eq!(again, bytes[..]);
    for room in 0..MESSAGE_LEN {
        assert!(message.encode(&mut again[..room]).is_err());
        assert!(Message::decode(&bytes[..room]).is_err());
    }
    // A changed bit is noticed.
    let bit = usize::from(*how) * 4 % (8 * MESSAGE_LEN);
    bytes[bit / 8] ^= 1 << (bit % 8);
    assert!(Message::decode(&bytes).is_err());
});
