//! The rule of every handshake: what is offered stays, unchanged, until it is taken.

/// What is offered on one channel and was not taken yet.
#[derive(Debug, Clone)]
pub(super) struct Offer<P>(Option<P>);

impl<P> Default for Offer<P> {
    fn default() -> Self {
        Offer(None)
    }
}

impl<P: PartialEq + Clone> Offer<P> {
    /// Looks at a cycle: what is offered in it, if anything, and whether the other side is ready. Returns what is
    /// taken, and the rule that is broken.
    #[inline]
    pub fn cycle(&mut self, offered: Option<P>, ready: bool) -> (Option<P>, Option<&'static str>) {
        let broken = match (self.0.take(), &offered) {
            (Some(_), None) => Some("valid fell before ready came"),
            (Some(before), Some(now)) if before != *now => Some("the payload changed while valid waited for ready"),
            _ => None,
        };
        if ready {
            return (offered, broken);
        }
        self.0 = offered;
        (None, broken)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_offer_stays_until_it_is_taken() {
        let mut offer = Offer::default();
        assert_eq!(offer.cycle(None, false), (None, None));
        assert_eq!(offer.cycle(Some(1), false), (None, None));
        assert_eq!(offer.cycle(Some(1), true), (Some(1), None));
        assert_eq!(offer.cycle(Some(2), true), (Some(2), None), "another after the first was taken");
        assert_eq!(offer.cycle(Some(3), false), (None, None));
        assert!(offer.cycle(Some(4), true).1.is_some_and(|rule| rule.contains("changed")));
        assert_eq!(offer.cycle(Some(5), false), (None, None));
        assert!(offer.cycle(None, true).1.is_some_and(|rule| rule.contains("fell")));
        assert_eq!(offer.cycle(None, false), (None, None));
    }
}
