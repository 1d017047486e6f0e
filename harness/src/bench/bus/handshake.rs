//! The rule of every handshake: what is offered stays, unchanged, until it is taken.

/// The payload that is offered on one channel and not transferred yet.
#[derive(Debug, Clone)]
pub(super) struct Offer<P> {
    waiting: Option<P>,
    /// The name of the payload in messages.
    payload_name: &'static str,
}

impl<P> Default for Offer<P> {
    fn default() -> Self {
        Offer::new("payload")
    }
}

impl<P> Offer<P> {
    /// Creates a channel on which nothing is offered; `payload_name` is what messages call its payload.
    pub fn new(payload_name: &'static str) -> Offer<P> {
        Offer { waiting: None, payload_name }
    }

    /// Forgets what is offered, in a reset.
    pub fn clear(&mut self) {
        self.waiting = None;
    }
}

impl<P: PartialEq + Clone> Offer<P> {
    /// Looks at a cycle: what is offered in it, if anything, and whether the other side is ready. Returns what is
    /// taken, and the rule that is broken.
    #[inline]
    pub fn cycle(&mut self, offered: Option<P>, ready: bool) -> (Option<P>, Option<String>) {
        let broken = self.watch(offered.as_ref(), ready);
        (offered.filter(|_| ready), broken)
    }

    /// Does the same for a payload that is too large to be moved in each cycle, and returns only the rule that is
    /// broken: the payload is transferred if `ready` is true.
    #[inline(always)]
    pub fn watch(&mut self, offered: Option<&P>, ready: bool) -> Option<String> {
        let broken = match &self.waiting {
            Some(before) if Some(before) != offered => Some(self.broken_rule(offered.is_some())),
            _ => None,
        };
        if ready {
            self.waiting = None;
        } else if self.waiting.is_none() || broken.is_some() {
            self.waiting = offered.cloned();
        }
        broken
    }

    #[cold]
    fn broken_rule(&self, is_offered: bool) -> String {
        if is_offered {
            format!("the {} changed while valid waited for ready", self.payload_name)
        } else {
            "valid fell before ready came".to_owned()
        }
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
