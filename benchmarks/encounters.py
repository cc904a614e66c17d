"""The collision monitor among people: contacts that a stop would have prevented, the speed at contact, needless stops.

`--live 40` drives encounters through the live node in real time.
"""

import os
from collections import Counter
from functools import partial

import numpy as np
from _encounter_runs import STEP, Base, Outcome, frame_of, run_encounter, settings_for, source_for
from _encounter_scenes import SITUATIONS, encounter, random_sensor
from _figures import count, measured
from _harness import Option, Run, in_processes, progress, run_benchmark

from reward_planner.core.safety.collision_monitor import CollisionMonitor
from scene_simulator.room.box_room import Solids
from scene_simulator.room.room_drive import RoomDrive

SLOWEST = 0.005  # A robot that is slower stands [m/s]
REASONS = ('none', 'never in view', 'in view for less than a period and a stop', 'walked into the standing robot')
LOOKAHEAD, SPEED = 0.4, 0.5


def run_seed(monitored: bool, seed: int) -> Outcome:
    """Run an encounter with the monitor or without it."""
    return run_encounter(encounter(seed), seed, monitored=monitored)


def reason_of(outcome: Outcome) -> str:
    """Return why a contact that was not avoidable happened."""
    if not outcome.contact or outcome.view is None:
        return REASONS[0]
    if outcome.speed < SLOWEST:
        return REASONS[3]
    return REASONS[2] if outcome.view.first_seen else REASONS[1]


def add_encounters(run: Run, name: str, seeds: list[int], found: list[Outcome]) -> None:
    """Add the table of contacts by situation."""
    heads = 'situation | encounters | avoidable contacts | moving contacts though in view | fastest of these m/s'
    table = run.table(name, heads, *REASONS[1:])
    for situation in (*SITUATIONS, 'all'):
        rows = [
            (s, o) for s, o in zip(seeds, found, strict=True) if situation in (SITUATIONS[s % len(SITUATIONS)], 'all')
        ]
        views = [(s, o) for s, o in rows if o.contact and o.view is not None]
        avoidable = [s for s, o in views if o.view is not None and o.view.avoidable]
        moving = [(s, o.speed) for s, o in views if o.view is not None and o.view.seen and o.speed >= SLOWEST]
        reasons = Counter(reason_of(o) for s, o in views if s not in avoidable)
        fastest = max((speed for _, speed in moving), default=0.0)
        table.add(situation, len(rows), count(len(avoidable), better='lower'), count(len(moving), better='lower'),
                  measured(fastest, '.2f'), *(reasons[each] for each in REASONS[1:]))  # fmt: skip
        if situation == 'all' and (avoidable or moving):
            run.note(f'{name}, seeds: avoidable {avoidable}, moving though in view {[s for s, _ in moving]}')


def room_stops(seed: int) -> tuple[int, float, float]:
    """Drive once around a furnished room; return stops without need, time driven and mean speed [s, m/s]."""
    scene, rng = RoomDrive(seed=seed), np.random.default_rng((25, seed))
    room, sensor = scene.room.boxes, random_sensor(rng)
    times = np.arange(0.0, scene.drive.duration, 0.05)
    path = [scene.drive.pose_at(float(t)) for t in times]
    points = np.array([(p.x, p.y) for p in path])
    monitor, base = CollisionMonitor(settings_for(0.5), {'sensor': source_for(sensor)}), Base(path[0], 0.5)
    stops, near, standing, next_frame = 0, 0, False, 0.0
    for step in range(int(3.0 * scene.drive.duration / STEP)):
        now, time = 100.0 + STEP * step, STEP * step
        if time >= next_frame:
            next_frame += 1.0 / sensor.rate
            monitor.add_frame('sensor', now, now, frame_of(sensor, sensor.ranges(room, Solids(), base.pose, rng)))
        if step % 5 == 0:
            near += int(np.hypot(*(points[near : near + 20] - (base.pose.x, base.pose.y)).T).argmin())
            ahead = points[near:][np.hypot(*(points[near:] - (base.pose.x, base.pose.y)).T) > LOOKAHEAD][:1]
            if len(ahead) == 0:
                break
            x, y = base.pose.inverse().transform(ahead)[0]
            monitor.add_command(now, SPEED, float(np.clip(2.0 * SPEED * y / (x * x + y * y), -1.5, 1.5)))
            decision = monitor.decide(now)
            base.give(time, decision.forward, decision.turn_rate)
        base.step(time)
        stops += base.forward < SLOWEST and not standing and time > 2.0
        standing = base.forward < SLOWEST
    return stops, time, near * 0.05 * SPEED / time


def main(run: Run, encounters: int, rooms: int, live: int) -> None:
    """Run encounters, rooms and live encounters."""
    seeds = list(range(run.seed * 100_000, run.seed * 100_000 + encounters))
    for name, chosen, monitored in (('Without', seeds[::20], False), ('With', seeds, True)):
        found = in_processes(partial(run_seed, monitored), chosen, name)
        add_encounters(run, f'{name} the monitor', chosen, found)
    driven = in_processes(room_stops, list(range(rooms)), 'rooms')
    stops, seconds = sum(f[0] for f in driven), sum(f[1] for f in driven)
    table = run.table('Furnished rooms', 'rooms | minutes | stops without need | in 10 minutes')
    per_10_minutes = measured(600.0 * stops / max(seconds, 1.0), '.2f')
    table.add(rooms, measured(seconds / 60.0, '.1f'), count(stops, better='lower'), per_10_minutes)
    if live:
        from _encounter_live import run_live  # noqa: PLC0415 needs ROS

        os.environ.setdefault('ROS_AUTOMATIC_DISCOVERY_RANGE', 'LOCALHOST')
        chosen = seeds[:live]
        add_encounters(run, 'Through the live node', chosen, [run_live(s) for s in progress(chosen, 'live')])


if __name__ == '__main__':
    run_benchmark(
        main,
        encounters=Option(2000, 12, 'with people'),
        rooms=Option(20, 1, 'furnished'),
        live=Option(0, 0, 'encounters through the live node, in real time'),
    )
