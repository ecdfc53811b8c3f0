use std::ops::Deref;
use std::sync::Arc;

use bytemuck::Pod;
use memmap2::MmapMut;

/// An immutable list; a long one is in huge pages where the system has them.
///
/// Accesses at random places of a list that is much longer than the caches otherwise wait for the
/// addresses of pages, too, of which the processor keeps a few thousand.
#[derive(Clone, Debug)]
pub(crate) enum Pages<T> {
    Heap(Arc<[T]>),
    Huge(Arc<MmapMut>),
}

/// The size in bytes from which lists are in huge pages, which have 2 MiB on x86.
const HUGE: usize = 1 << 23;

impl<T: Pod> Pages<T> {
    /// Returns the list of the items.
    pub(crate) fn new(items: impl ExactSizeIterator<Item = T>) -> Self {
        let bytes = items.len() * size_of::<T>();
        if bytes >= HUGE
            && let Some(mut memory) = huge_pages(bytes)
        {
            let list: &mut [T] = bytemuck::cast_slice_mut(&mut memory);
            for (place, item) in list.iter_mut().zip(items) {
                *place = item;
            }
            return Self::Huge(Arc::new(memory));
        }
        Self::Heap(items.collect())
    }
}

impl<T: Pod> Deref for Pages<T> {
    type Target = [T];

    fn deref(&self) -> &[T] {
        match self {
            Self::Heap(list) => list,
            Self::Huge(memory) => bytemuck::cast_slice(memory),
        }
    }
}

/// Returns memory for which huge pages are requested.
#[cfg(target_os = "linux")]
fn huge_pages(bytes: usize) -> Option<MmapMut> {
    let memory = MmapMut::map_anon(bytes).ok()?;
    memory.advise(memmap2::Advice::HugePage).ok()?;
    Some(memory)
}

#[cfg(not(target_os = "linux"))]
fn huge_pages(_: usize) -> Option<MmapMut> {
    None
}

#[cfg(test)]
mod tests {
    use super::{HUGE, Pages};

    #[test]
    fn lists_have_their_items() {
        for len in [0, 1, HUGE / 8 - 1, HUGE / 8, HUGE / 8 + 1] {
            let list = Pages::new((0..len).map(|i| i as f64));
            assert_eq!(list.len(), len);
            assert!(list.iter().enumerate().all(|(i, &x)| x.to_bits() == (i as f64).to_bits()));
        }
    }
}
