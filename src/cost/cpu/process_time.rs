//! The time of the process on processors.

use std::fs;

/// The time in milliseconds that all threads of this process have been on processors: 0 where the system is not
/// Linux. Threads that ended are not in it; Bevy keeps its own for as long as the app lives.
pub fn process_ms() -> f64 {
    let Ok(threads) = fs::read_dir("/proc/self/task") else {
        return 0.0;
    };
    let nanoseconds = threads.flatten().filter_map(|thread| {
        let text = fs::read_to_string(thread.path().join("schedstat")).ok()?;
        text.split(' ').next()?.parse::<u64>().ok()
    });
    nanoseconds.sum::<u64>() as f64 * 1e-6
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use std::time::{Duration, Instant};

    use super::*;

    #[test]
    fn work_counts() {
        let before = process_ms();
        let start = Instant::now();
        while start.elapsed() < Duration::from_millis(200) {
            std::hint::spin_loop();
        }
        assert!(process_ms() - before > 10.0, "{}", process_ms() - before);
    }
}
