//! A queue of fixed size between tasks. Like embassy-sync's channel, but without a path to a
//! panic: `make no-panic` follows what the control task calls.

use core::cell::RefCell;
use core::future::poll_fn;
use core::task::Poll;

use critical_section::Mutex;
use embassy_sync::waitqueue::AtomicWaker;
use heapless::Deque;

/// First in, first out; one task at most waits for items.
pub struct Queue<T, const N: usize> {
    // Borrowed within critical sections only, so a borrow never fails.
    items: Mutex<RefCell<Deque<T, N>>>,
    filled: AtomicWaker,
}

impl<T, const N: usize> Queue<T, N> {
    /// Empty.
    pub const fn new() -> Self {
        Self { items: Mutex::new(RefCell::new(Deque::new())), filled: AtomicWaker::new() }
    }

    fn with<U>(&self, what: impl FnOnce(&mut Deque<T, N>) -> U) -> Option<U> {
        critical_section::with(|cs| {
            self.items.borrow(cs).try_borrow_mut().ok().map(|mut items| what(&mut items))
        })
    }

    /// # Errors
    /// The item, where there is no room.
    pub fn try_send(&self, item: T) -> Result<(), T> {
        let sent = critical_section::with(|cs| match self.items.borrow(cs).try_borrow_mut() {
            Ok(mut items) => items.push_back(item),
            Err(_) => Err(item),
        });
        if sent.is_ok() {
            self.filled.wake();
        }
        sent
    }

    /// The oldest item.
    pub fn try_receive(&self) -> Option<T> {
        self.with(Deque::pop_front).flatten()
    }

    /// Waits for an item.
    pub async fn receive(&self) -> T {
        poll_fn(|context| {
            self.filled.register(context.waker());
            self.try_receive().map_or(Poll::Pending, Poll::Ready)
        })
        .await
    }

    /// Items that wait.
    pub fn len(&self) -> usize {
        self.with(|items| items.len()).unwrap_or(0)
    }

    /// Whether none waits.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Drops what waits and tells how many they were.
    pub fn clear(&self) -> usize {
        let clear = |items: &mut Deque<T, N>| {
            let number = items.len();
            items.clear();
            number
        };
        self.with(clear).unwrap_or(0)
    }
}

impl<T, const N: usize> Default for Queue<T, N> {
    fn default() -> Self {
        Self::new()
    }
}
