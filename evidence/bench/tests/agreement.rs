//! The peers against the reference: each within what its method promises, every event found.

use bench::schema::{Answer, Peer, Task, Verdict};
use bench::tabulated::Tabulated;
use oracles::model::Model;
use oracles::reference::{Record, stored};

fn judge(solve: impl FnOnce(&Model<f64>, &Task) -> Result<Answer, String>) -> Verdict {
    let record: Record = stored(20).unwrap();
    let model = Model::new(&record.scene);
    let task = Task::cycle(&record);
    solve(&model, &task).unwrap().judge(&record, &task)
}

#[test]
fn tabulated_propagators_are_exact_but_for_their_scan() {
    let verdict = judge(|m, task| Tabulated::new(m, 5e-7).run(task));
    assert!(verdict.error < 1e-7, "{verdict:?}");
    assert_eq!((verdict.missed, verdict.spurious), (0, 0));
}
