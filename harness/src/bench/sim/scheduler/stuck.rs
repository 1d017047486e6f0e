//! The report of what every task waits for.

use super::Core;
use super::task_state::{Task, TaskWait};
use super::wait_table::{State, Target, WaitId, WaitSlot, WaitTable, Waiting};
use crate::bench::report::{StuckReport, TaskReport};
use crate::bench::sim::task::TaskId;
use crate::bench::sim::trigger::Edge;
use crate::engine::model::load;

impl Core {
    /// Returns what every living task waits for.
    pub fn report(&self) -> StuckReport {
        let tasks = self.tasks.borrow();
        let reports = tasks
            .iter()
            .enumerate()
            .filter(|(_, task)| task.ending.is_none())
            .map(|(index, task)| {
                let id = TaskId { index: index as u32, generation: task.generation };
                let mut waits: Vec<String> = {
                    let wait_table = self.wait_table.borrow();
                    let of_task = |n: &&WaitSlot| {
                        n.state == State::Armed
                            && match &n.target {
                                Target::Task(t) => *t == id,
                                Target::Waker(w) => w.will_wake(&task.waker),
                                Target::Parent(..) => false,
                            }
                    };
                    wait_table.iter().filter(of_task).map(|n| self.describe(&n.waiting, &wait_table, &tasks)).collect()
                };
                if let TaskWait::Edge = task.wait {
                    waits.push(self.describe_edge(task.edge.signal, task.edge.edge, task.edge.count));
                }
                if waits.is_empty() {
                    waits.push(if task.queued {
                        "is ready to run".into()
                    } else {
                        "nothing the harness knows of".into()
                    });
                }
                TaskReport { task: task.name.clone(), waits }
            })
            .collect();
        let stopped = self.clocks.borrow().iter().all(|c| !c.running);
        StuckReport { time: self.now(), tasks: reports, no_clock: stopped }
    }

    fn describe(&self, waiting: &Waiting, wait_table: &WaitTable, tasks: &[Task]) -> String {
        let part = |p: &WaitId| match wait_table.get(*p) {
            Some(wait_id) if wait_id.state == State::Armed => self.describe(&wait_id.waiting, wait_table, tasks),
            _ => "done".into(),
        };
        match waiting {
            Waiting::Edge(signal, edge, count) => self.describe_edge(*signal, *edge, *count),
            Waiting::Until(time) => format!("Timer until {time}"),
            Waiting::Named(name) => (*name).to_owned(),
            Waiting::Sync(sync) => format!("{}({})", if sync.0.exclusive { "Lock" } else { "Event" }, sync.0.name),
            Waiting::Join(id) => format!("the end of task '{}'", tasks.get(id.index as usize).map_or("", |t| &t.name)),
            Waiting::First(parts) => format!("First({})", parts.iter().map(part).collect::<Vec<_>>().join(", ")),
            Waiting::Combine(parts, _) => format!("Combine({})", parts.iter().map(part).collect::<Vec<_>>().join(", ")),
        }
    }

    fn describe_edge(&self, signal: u32, edge: Edge, count: u64) -> String {
        let (name, bit) = match edge {
            Edge::Rising => ("RisingEdge", None),
            Edge::Falling => ("FallingEdge", None),
            Edge::Any => ("ValueChange", None),
            Edge::RisingBit(at) => ("RisingEdge", Some(at)),
            Edge::FallingBit(at) => ("FallingEdge", Some(at)),
            Edge::AnyBit(at) => ("ValueChange", Some(at)),
        };
        let bit = bit.map_or(String::new(), |at| format!("[{at}]"));
        let state = &self.signals[signal as usize];
        // SAFETY: the model lives as long as the core.
        let value = unsafe { load(state.data, state.storage) };
        let times = if count > 1 { format!(", {count} times") } else { String::new() };
        format!("{name}({}{bit}{times}), which is {value:#x}", self.signal_name(signal))
    }
}
