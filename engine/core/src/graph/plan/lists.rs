//! Items by a number, one list behind the other in one piece of memory.

/// A list for each number from 0 on.
#[derive(PartialEq, Eq)]
pub(super) struct Lists<T> {
    /// By number, then the total: where its list begins.
    first: Vec<u32>,
    items: Vec<T>,
}

impl<T> Default for Lists<T> {
    fn default() -> Self {
        Self { first: vec![0], items: Vec::new() }
    }
}

impl<T: Copy> Lists<T> {
    /// Items with their numbers, of which there are `numbers`; those of one stay in the order they come in.
    pub(super) fn new(numbers: usize, items: impl Iterator<Item = (usize, T)> + Clone) -> Self {
        // One further than they will be: a list's beginning moves on to its end while its items are put in.
        let mut first = vec![0; numbers + 2];
        items.clone().for_each(|(number, _)| first[number + 2] += 1);
        let mut total = 0;
        for begin in &mut first {
            total += *begin;
            *begin = total;
        }
        let any = items.clone().next();
        let mut sorted = any.map_or_else(Vec::new, |(_, any)| vec![any; total as usize]);
        for (number, item) in items {
            let place = &mut first[number + 1];
            sorted[*place as usize] = item;
            *place += 1;
        }
        first.truncate(numbers + 1);
        Self { first, items: sorted }
    }

    /// How many lists there are.
    pub(super) fn count(&self) -> usize {
        self.first.len() - 1
    }

    /// The list of a number.
    pub(super) fn of(&self, number: usize) -> &[T] {
        &self.items[self.first[number] as usize..self.first[number + 1] as usize]
    }

    /// As [`Lists::of`].
    pub(super) fn of_mut(&mut self, number: usize) -> &mut [T] {
        &mut self.items[self.first[number] as usize..self.first[number + 1] as usize]
    }

    /// The lists, one behind the other.
    pub(super) fn all(&self) -> &[T] {
        &self.items
    }

    /// As [`Lists::all`].
    pub(super) fn into_all(self) -> Vec<T> {
        self.items
    }

    /// Leaves out what is not to stay. `stays`: an item, behind the last of its list that stayed.
    pub(super) fn retain(&mut self, stays: impl Fn(Option<&T>, &T) -> bool) {
        let (mut kept, mut begin) = (0, 0);
        for number in 1..self.first.len() {
            let (first, end) = (kept, self.first[number] as usize);
            for index in begin..end {
                if stays(self.items[first..kept].last(), &self.items[index]) {
                    self.items[kept] = self.items[index];
                    kept += 1;
                }
            }
            (begin, self.first[number]) = (end, kept as u32);
        }
        self.items.truncate(kept);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn items_come_by_number_in_their_order() {
        let items = [(2, 'a'), (0, 'b'), (2, 'c'), (2, 'c'), (0, 'd'), (1, 'd')];
        let mut lists = Lists::new(4, items.into_iter());
        let all =
            |lists: &Lists<char>| (0..lists.count()).map(|n| lists.of(n).iter().collect()).collect::<Vec<String>>();
        assert_eq!(all(&lists), ["bd", "d", "acc", ""]);
        lists.retain(|last, item| *item != 'b' && last != Some(item));
        assert_eq!(all(&lists), ["d", "d", "ac", ""]);
        assert_eq!(all(&Lists::new(2, std::iter::empty())), ["", ""]);
    }
}
