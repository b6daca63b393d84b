"""Numbers that steer a run over many machines."""

#: Machines of a batch, the unit of scheduling and of a result file. 50 machines of three short recordings are half a
#: second of work, far above the engine's milliseconds a task; a killed worker repeats at most one batch.
BATCH = 50
#: Batches submitted ahead, for each worker: enough to keep it busy, few enough that memory does not grow with the fleet.
AHEAD = 3
#: Workers that may die with a batch before its machines are given up. The engine blames every batch that a lost worker
#: held, not only the one it worked on, so this is above the engine's own 3.
DEATHS = 5
#: Seconds a machine may take before its command is ended.
TIMEOUT_S = 3600.0
#: Characters of a command's text that a status row keeps.
TEXT = 4000
#: Seconds between lines of progress where stderr is no terminal.
PROGRESS_S = 30.0
#: Samples a second of a synthetic machine.
SYNTHETIC_RATE_HZ = 25_600.0
#: Samples of a synthetic recording: a tenth of a second, as in FEMTO.
SYNTHETIC_SAMPLES = 2_560
#: Share of the synthetic machines that have a defect of the outer race.
SYNTHETIC_DEFECTS = 0.1
