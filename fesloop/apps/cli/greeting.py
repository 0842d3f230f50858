"""What `fesloop` says to somebody who has typed nothing else yet."""

GREETING = """\
fesloop: closed-loop co-simulation of functional electrical stimulation of the
hand, where the hand tracker is one block of an exactly timed loop.

A virtual patient's paralysed hand learns to grasp through a tracker:
    fesloop run grasp_ilc                           (about 35 s)
  the error of each trial, what of it is the tracker's, and what was held.

Electrodes that open the hand are searched for on arrays on the forearm:
    fesloop run array_search_two_phase              (about 70 s)
  what was found, how well it does, queries and minutes of the patient's time.

The same controllers beside hardware, in step with the wall clock:
    fesloop run hil_dry_stimulator --realtime       (about 9 s)
  how late each tick was; commands go to a device that only writes them down.

What latency, trackers and patients do to any of these is a study (extra
`study`):  fesloop study linear_map

fesloop list            every experiment, how long it takes and what it needs
fesloop check NAME      how an experiment is wired, and its latency budget
fesloop report RUN.h5   a run, several, or a study as one page to read and share
fesloop --help          all commands
Documentation: README.md and docs/ where fesloop's sources are.
"""
