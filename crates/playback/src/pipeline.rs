//! Two stages of work that overlap: the first fills a buffer while the second empties another one.

use rhytid_core::Result;
use rhytid_core::buffer_ring::buffer_ring;
use std::{panic, thread};

/// The number of buffers that are used in turn: one is filled while the other one is emptied. A third was no
/// faster.
pub(crate) const BUFFERS: usize = 2;

/// Fills a buffer for each of `items` on a thread of its own, and hands the full buffers to `empty` on this
/// thread.
///
/// The order of the items stays. There are `buffers` buffers, at least 1, and they are used again and again.
/// So memory does not grow with the number of items.
///
/// # Errors
/// The error of the first item that fails, as if each item had been filled and emptied before the next one.
/// After an error nothing more is handed to `empty`. At most the buffers that are empty by then are still
/// filled.
pub(crate) fn run<Items, Buffer>(
    buffers: usize,
    items: Items,
    mut fill: impl FnMut(Items::Item, &mut Buffer) -> Result<()> + Send,
    mut empty: impl FnMut(&mut Buffer) -> Result<()>,
) -> Result<()>
where
    Items: Iterator + Send,
    Buffer: Default + Send,
{
    thread::scope(|scope| {
        let (filler, emptier) = buffer_ring((0..buffers).map(|_| Buffer::default()));
        let filling = scope.spawn(move || {
            for item in items {
                // After an error, the other stage closes the channel.
                let Some(mut buffer) = filler.empty() else { break };
                fill(item, &mut buffer)?;
                if !filler.hand_over(buffer) {
                    break;
                }
            }
            Ok(())
        });
        let all_emptied = std::iter::from_fn(|| emptier.full()).try_for_each(|mut buffer| {
            empty(&mut buffer)?;
            emptier.give_back(buffer);
            Ok(())
        });
        drop(emptier);
        let all_filled = filling.join().unwrap_or_else(|fault| panic::resume_unwind(fault));
        // The item that was emptied comes before the one that was being filled.
        all_emptied.and(all_filled)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use rhytid_core::Error;
    use std::sync::atomic::{AtomicUsize, Ordering};
    use std::time::Duration;

    const ITEMS: usize = 20;

    fn fault(what: &str, item: usize) -> Error {
        Error::input(format!("{what} {item}"))
    }

    /// Sends numbers from 0 up through `buffers` until one of the stages fails at a number. The result is
    /// what the second stage got, and how the run ended.
    fn numbers(buffers: usize, fill_fails: usize, empty_fails: usize) -> (Vec<usize>, Result<()>) {
        let mut got = Vec::new();
        let fill = |item, buffer: &mut Vec<usize>| {
            buffer.push(item);
            if item == fill_fails { Err(fault("fill", item)) } else { Ok(()) }
        };
        let end = run(buffers, 0..ITEMS, fill, |buffer| {
            let item = buffer.pop().unwrap();
            assert!(buffer.is_empty());
            if item == empty_fails {
                return Err(fault("empty", item));
            }
            got.push(item);
            Ok(())
        });
        (got, end)
    }

    #[test]
    fn everything_comes_once_and_in_order() {
        for buffers in 1..5 {
            let (got, end) = numbers(buffers, ITEMS, ITEMS);
            end.unwrap();
            assert_eq!(got, Vec::from_iter(0..ITEMS), "{buffers} buffers");
        }
        run(1, 0..0, |_, (): &mut ()| panic!("nothing to fill"), |_| panic!("nothing to empty")).unwrap();
    }

    #[test]
    fn the_first_error_in_the_items_order_ends_both_stages() {
        for buffers in 1..5 {
            for at in [0, 1, 7, ITEMS - 1] {
                for (fill_fails, empty_fails, expected) in [
                    (at, ITEMS, format!("fill {at}")),
                    (ITEMS, at, format!("empty {at}")),
                    (at, at, format!("fill {at}")),
                    (at + 1, at, format!("empty {at}")),
                    (at, at + 1, format!("fill {at}")),
                ] {
                    let (got, end) = numbers(buffers, fill_fails, empty_fails);
                    assert_eq!(end.unwrap_err().to_string(), expected, "{buffers} buffers");
                    assert_eq!(got, Vec::from_iter(0..at), "{buffers} buffers, {expected}");
                }
            }
        }
    }

    #[test]
    fn the_stages_overlap_and_no_more_buffers_are_made() {
        /// Counts the buffers that are made.
        #[derive(Debug)]
        struct Buffer;
        static MADE: AtomicUsize = AtomicUsize::new(0);
        impl Default for Buffer {
            fn default() -> Self {
                MADE.fetch_add(1, Ordering::SeqCst);
                Self
            }
        }
        let (filled, mut emptied, mut most_ahead) = (AtomicUsize::new(0), 0, 0);
        let fill = |_, _: &mut Buffer| {
            filled.fetch_add(1, Ordering::SeqCst);
            Ok(())
        };
        run(BUFFERS, 0..ITEMS, fill, |_| {
            // This gives the other stage time to go as far ahead as it can.
            thread::sleep(Duration::from_millis(20));
            most_ahead = most_ahead.max(filled.load(Ordering::SeqCst) - emptied);
            emptied += 1;
            Ok(())
        })
        .unwrap();
        assert_eq!((most_ahead, MADE.load(Ordering::SeqCst)), (BUFFERS, BUFFERS));
    }

    #[test]
    #[should_panic(expected = "broken")]
    fn a_panic_of_the_other_thread_is_passed_on() {
        let _ = run(2, 0..ITEMS, |_, (): &mut ()| panic!("broken"), |_| Ok(()));
    }
}
