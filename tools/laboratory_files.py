#!/usr/bin/env python3
"""Writes a data set of the rig as a laboratory would have recorded it, to try `stickslip import recording` on.

  laboratory_files.py DATA OUT SEED

Forces: one file a trial, 1 kHz, `;` between cells, microseconds since boot, N and N mm, the reactions on fingers and
pusher, the sensors' own axes, noise of 20 mN and 0.4 N mm added to lines between the rig's samples. Motion capture: another
file, 120 Hz, mm, y up, quaternions x, y, z, w, an origin of its own, its own clock. Names as obj4_g20_v10_s-10_r1_ft.csv.
truth.json says what to add to the motion capture's time. Tables of the rig are CSV (the default).
"""

import csv
import json
import math
import random
import sys
from pathlib import Path

ORIGIN_M = (1.2345, 0.8, -0.321)


def between(rows, times, t):
    """Place of time t among the rows, and the share to the next."""
    lo, hi = 0, len(times) - 2
    while lo < hi:
        mid = (lo + hi + 1) // 2
        lo, hi = (mid, hi) if times[mid] <= t else (lo, mid - 1)
    return rows[lo], rows[lo + 1], (t - times[lo]) / (times[lo + 1] - times[lo])


def main(source, out, seed):
    draw = random.Random(seed)
    source, out = Path(source), Path(out)
    out.mkdir(parents=True)
    boot_s, offset_s = draw.uniform(100, 4000), draw.uniform(-60000, 60000)
    for info in csv.DictReader(open(source / "trials.csv")):
        read = [{k: float(v) for k, v in row.items() if v} for row in csv.DictReader(open(source / info["file"]))]
        times = [row["t_s"] for row in read]
        boot_s += draw.uniform(20, 40)
        slope = round(math.degrees(float(info["slope_rad"] or 0)))
        speed = round(1e3 * float(info["speed_m_s"]))
        name = f"{info['object']}_g{float(info['grip_n']):.0f}_v{speed}_s{slope}_r{info['run']}"
        with open(out / f"{name}_ft.csv", "w") as file:
            ends = [end for end in ("Fx", "Fy", "Fz", "Tx", "Ty", "Tz")]
            heads = [f"{end}_{where}" for where in ("left", "right", "plate") for end in ends]
            file.write(";".join(["time_us", "grip_set_N", *heads]) + "\n")
            for k in range(int(1e3 * (times[-1] - times[0]))):
                a, b, share = between(read, times, times[0] + 1e-3 * k)
                cells = [f"{1e6 * (boot_s + 1e-3 * k):.0f}", f"{a.get('grip_cmd_n', 0):.1f}"]
                for body in ("finger1", "finger2", "pusher"):
                    for kind, unit, scale, noise in (("f", "n", 1, 0.02), ("t", "nm", 1e3, 0.4)):
                        x, y, z = (
                            -scale * (a[key] + share * (b[key] - a[key])) + draw.gauss(0, noise)
                            for key in (f"{body}_{kind}{axis}_{unit}" for axis in "xyz")
                        )
                        # Ours are the sensor's y, z, x; the pusher's y, -x, z.
                        own = (z, x, y) if body != "pusher" else (-y, x, z)
                        cells += [f"{value:.4f}" for value in own]
                file.write(";".join(cells) + "\n")
        with open(out / f"{name}_mocap.csv", "w") as file:
            ends = ["x_mm", "y_mm", "z_mm", "qx", "qy", "qz", "qw"]
            file.write(",".join(["t"] + [f"{body}_{end}" for body in ("object", "hand") for end in ends]) + "\n")
            begin_s = times[0] + draw.uniform(0, 1 / 120)
            for k in range(int(120 * (times[-1] - begin_s))):
                t = begin_s + k / 120
                a, b, share = between(read, times, t)
                near = a if share < 0.5 else b
                cells = [f"{t - times[0] + boot_s - offset_s:.6f}"]
                for body in ("object", "gripper"):
                    # Noise as the tracker's: that of the sample next to it, on the line between the samples.
                    x, y, z = (a[f"{body}_{n}_m"] + share * (b[f"{body}_{n}_m"] - a[f"{body}_{n}_m"]) for n in "xyz")
                    place = [x + ORIGIN_M[0], z + ORIGIN_M[1], -y + ORIGIN_M[2]]
                    w, qx, qy, qz = (near[f"{body}_q{n}"] for n in "wxyz")
                    cells += [f"{1e3 * value:.4f}" for value in place] + [f"{value:.7f}" for value in (qx, qz, -qy, w)]
                file.write(",".join(cells) + "\n")
    (out / "truth.json").write_text(json.dumps({"offset_s": offset_s, "origin_m": ORIGIN_M}))


if __name__ == "__main__":
    if len(sys.argv) != 4:
        sys.exit(__doc__)
    main(sys.argv[1], sys.argv[2], int(sys.argv[3]))
