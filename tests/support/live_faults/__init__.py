"""Live runs with faults at random moments: ``python -m live_faults --rounds 300 --seed 0``.

Each round makes a camera, motors and a robot that hears them, drives, and lets one thing go wrong,
or two at once. The robot must stand within the time that is promised, the trace and the recorded
session must have what was before the fault, nothing may hang, and threads and descriptors must be
gone. ``--cameras firewire gige``: with cameras on the virtual bus and on loopback.
"""
