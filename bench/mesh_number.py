#!/usr/bin/env python3
"""The mesh number of the certificate against the truth: bodies on voxels of several h, each compared
with the same body on voxels four times as fine as the finest of them (in motion three times).

    bench/mesh_number.py build/release/elastogen           ten bodies at rest, at three h each
    bench/mesh_number.py ... --set unseen                   five that were not looked at before
    bench/mesh_number.py ... --set motion                   bodies that move
    bench/mesh_number.py ... --assets FOLDER                meshes of a folder, held at their foot

ratio: the number over the true error of the vertices, both as rms (and as largest).
"""
import argparse
import itertools
import json
import math
import struct
import subprocess
import tempfile
from pathlib import Path

import numpy

# Meshes -----------------------------------------------------------------------------------------


def of_cells(cells, edge, fine=1):
    """The surface of cubes on a lattice; each square is cut into fine x fine x 2 triangles."""
    cells = set(cells)
    number, points, triangles = {}, [], []

    def vertex(place):
        if place not in number:
            number[place] = len(points)
            points.append([edge * c / fine for c in place])
        return number[place]

    for cell in sorted(cells):
        for axis, side in itertools.product(range(3), (0, 1)):
            beside = list(cell)
            beside[axis] += 1 if side else -1
            if tuple(beside) in cells:
                continue
            u, v = (axis + 1) % 3, (axis + 2) % 3
            for i, j in itertools.product(range(fine), repeat=2):
                corners = []
                for a, b in ((0, 0), (1, 0), (1, 1), (0, 1)):
                    place = [fine * c for c in cell]
                    place[axis] += fine * side
                    place[u] += i + a
                    place[v] += j + b
                    corners.append(vertex(tuple(place)))
                if not side:
                    corners.reverse()
                triangles += [corners[:3], [corners[0], corners[2], corners[3]]]
    return numpy.array(points, float), numpy.array(triangles)


def block(*count, edge=0.01):
    return of_cells(itertools.product(*(range(c) for c in count)), edge)


def revolved(profile, count=40):
    """A closed surface about the axis y; profile: (radius, y) from pole to pole, upwards."""
    points, triangles = [[0, profile[0][1], 0]], []
    rings = profile[1:-1]
    for r, y in rings:
        for k in range(count):
            a = 2 * math.pi * k / count
            points.append([r * math.cos(a), y, -r * math.sin(a)])
    points.append([0, profile[-1][1], 0])
    ring = lambda i, k: 1 + i * count + k % count
    for k in range(count):
        triangles.append([0, ring(0, k + 1), ring(0, k)])
        triangles.append([len(points) - 1, ring(len(rings) - 1, k), ring(len(rings) - 1, k + 1)])
        for i in range(len(rings) - 1):
            a, b, c, d = ring(i, k), ring(i, k + 1), ring(i + 1, k + 1), ring(i + 1, k)
            triangles += [[a, b, c], [a, c, d]]
    return numpy.array(points, float), numpy.array(triangles)


def ellipsoid(a, b, c):
    profile = [(math.sin(t), -math.cos(t)) for t in numpy.linspace(0, math.pi, 25)]
    points, triangles = revolved(profile)
    return points * [a, b, c], triangles


def cone(low, high, height):
    side = [(low + (high - low) * t, height * t) for t in numpy.linspace(0, 1, 25)]
    foot = [(low * t, 0) for t in numpy.linspace(0, 1, 6)[:-1]]
    head = [(high * t, height) for t in numpy.linspace(1, 0, 6)[1:]]
    return revolved(foot + side + head)


def torus(big, small, count=(56, 24)):
    points, triangles = [], []
    for i, k in itertools.product(range(count[0]), range(count[1])):
        a, b = 2 * math.pi * i / count[0], 2 * math.pi * k / count[1]
        r = big + small * math.cos(b)
        points.append([r * math.cos(a), r * math.sin(a), small * math.sin(b)])
    at = lambda i, k: i % count[0] * count[1] + k % count[1]
    for i, k in itertools.product(range(count[0]), range(count[1])):
        a, b, c, d = at(i, k), at(i + 1, k), at(i + 1, k + 1), at(i, k + 1)
        triangles += [[a, b, c], [a, c, d]]
    return numpy.array(points, float), numpy.array(triangles)


def turned(mesh, axis, degrees):
    k = numpy.array(axis, float) / numpy.linalg.norm(axis)
    t = math.radians(degrees)
    cross = numpy.array([[0, -k[2], k[1]], [k[2], 0, -k[0]], [-k[1], k[0], 0]])
    turn = numpy.eye(3) + math.sin(t) * cross + (1 - math.cos(t)) * cross @ cross
    return mesh[0] @ turn.T, mesh[1]


def cells_of(text, depth):
    """Cells of a drawing, top line first, in `depth` layers."""
    lines = text.split()[::-1]
    return [(x, y, z) for y, line in enumerate(lines) for x, c in enumerate(line) if c == '#'
            for z in range(depth)]


# Bodies -----------------------------------------------------------------------------------------

L_SHAPE = '###### ###### ###### ###### ####.. ####..'.replace('####..', '##....')
FRAME = '######## ######## ##....## ##....## ##....## ##....## ##....##'
T_SHAPE = '######### ######### ...###... ...###... ...###... ...###... ...###...'
S_SHAPE = '######## ######## ##...... ##...... ######## ######## ......## ......## ######## ########'


def case(mesh, thick, young, *words, poisson=0.4, across=(3, 4, 5)):
    """A body with its thickness [m]; `across` voxels lie in it."""
    return {'mesh': mesh, 'thick': thick, 'across': across,
            'words': ['--law', 'neo-hookean', '--young', str(young), '--poisson', str(poisson),
                      '--density', '1000', '--energy', 'analytic', '--up', 'y', *words]}


def studied():
    return {
        'bar': case(block(20, 4, 4), 0.04, 1e5, '--pin', 'x<5%'),
        'turned bar': case(turned(block(20, 4, 4), (1, 2, 3), 27), 0.04, 1e5, '--pin', 'x<12%'),
        'plate': case(block(6, 2, 6), 0.02, 3e4, '--pin', 'x<10%', poisson=0.3),
        'sheared block': case(block(8, 8, 8), 0.08, 1e4, '--pin', 'y<10%', '--gravity', '9.81,0,0'),
        'L': case(of_cells(cells_of(L_SHAPE, 2), 0.01, 2), 0.02, 4e4, '--pin', 'y<5%'),
        'frame': case(of_cells(cells_of(FRAME, 2), 0.01, 2), 0.02, 2e4, '--pin', 'y<5%',
                      '--gravity', '6,-6,3'),
        'column': case(cone(0.03, 0.03, 0.12), 0.06, 3e4, '--pin', 'y<5%', poisson=0.45),
        'carrot': case(cone(0.01, 0.03, 0.15), 0.04, 1e4, '--pin', 'y>92%', poisson=0.45),
        'egg': case(ellipsoid(0.04, 0.06, 0.04), 0.08, 2e4, '--pin', 'y<10%'),
        'ring': case(torus(0.07, 0.02), 0.04, 3e4, '--pin', 'y>95%'),
    }


def unseen():
    return {
        'T': case(turned(of_cells(cells_of(T_SHAPE, 3), 0.01, 2), (0, 1, 0), 20), 0.03, 3e4,
                  '--pin', 'y<6%', '--gravity', '5,-5,0'),
        'S': case(of_cells(cells_of(S_SHAPE, 2), 0.01, 2), 0.02, 1e5, '--pin', 'y<4%', poisson=0.3, across=(3, 4)),
        'lying ring': case(turned(torus(0.06, 0.02), (1, 0, 0), 90), 0.04, 3e4, '--pin', 'x<12%'),
        'disk': case(ellipsoid(0.08, 0.025, 0.06), 0.05, 2e4, '--pin', 'x<15%', poisson=0.47),
        'tapered bar': case(turned(cone(0.035, 0.012, 0.2), (0.2, 0, 1), 70), 0.045, 1e5,
                            '--pin', 'x>88%'),
    }


def moving():
    def clip(mesh, thick, *words):
        body = case(mesh, thick, 1e5, *words, '--frames', '20', across=(4, 8))
        return {**body, 'finer': 3}

    bar = turned(block(12, 3, 3), (1, 2, 3), 27)
    return {
        'bar swings': clip(block(12, 3, 3), 0.03, '--pin', 'x<5%'),
        'turned bar swings': clip(bar, 0.03, '--pin', 'x<20%'),
        'bar spins': clip(bar, 0.03, '--gravity', '0,0,0', '--spin', '0,8,4'),
        'egg falls': clip(ellipsoid(0.03, 0.045, 0.03), 0.06, '--floor', 'y=-0.07'),
        'bar falls': clip(bar, 0.03, '--floor', 'y=-0.03'),
    }


def of_folder(folder):
    """Meshes as files, 30 cm long, of jelly, held at their foot."""
    words = ['--size', '30 cm', '--material', 'jelly', '--energy', 'analytic', '--pin', 'y<10%']
    return {path.stem: {'mesh': path, 'thick': 0.3, 'across': (12, 16, 24), 'words': words}
            for path in sorted(Path(folder).iterdir()) if path.suffix in ('.obj', '.ply', '.stl')}


# Runs -------------------------------------------------------------------------------------------


def write_obj(path, mesh):
    with open(path, 'w') as file:
        for p in mesh[0]:
            file.write('v %.9g %.9g %.9g\n' % tuple(p))
        for t in mesh[1]:
            file.write('f %d %d %d\n' % tuple(t + 1))


def frames_of(path):
    """Positions in a point cache, (frames, points, 3)."""
    data = path.read_bytes()
    points, frames = struct.unpack('<i', data[16:20])[0], struct.unpack('<i', data[28:32])[0]
    return numpy.frombuffer(data[32:], '<f4').reshape(frames, points, 3).astype(float)


def run(program, statics, mesh, h, words, folder, number):
    """Positions, the frames' numbers and the report."""
    out, log, report = folder / 'a.pc2', folder / 'a.log', folder / 'a.json'
    verb = ['simulate', str(mesh), '--static'] if statics else ['animate', str(mesh), '--device', 'cpu']
    command = [program, *verb, '--h', repr(h), *words, '-o', str(out), '--log-json', str(log),
               '--report', str(report), '--mesh-error', 'on' if number else 'off', '--quiet']
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode:
        print('  exit', done.returncode, done.stderr.strip()[-200:], flush=True)
    lines = [json.loads(line) for line in log.read_text().splitlines()]
    numbers = [line['mesh_error'] for line in lines if 'mesh_error' in line]
    return frames_of(out), numbers, json.loads(report.read_text())


def size_of(errors):
    """rms and largest length of vectors, (points, 3)."""
    square = (errors ** 2).sum(-1)
    return math.sqrt(square.mean()), math.sqrt(square.max())


def study(program, name, body, statics, folder, truths):
    mesh = body['mesh']
    if not isinstance(mesh, Path):
        write_obj(folder / 'a.obj', mesh)
        mesh = folder / 'a.obj'
    finest = body['thick'] / (body.get('finer', 4) * max(body['across']))
    kept = truths and Path(truths) / (name.replace(' ', '-') + '.npy')
    if kept and kept.exists():
        truth = numpy.load(kept)
    else:
        truth = run(program, statics, mesh, finest, body['words'], folder, False)[0]
        if kept:
            numpy.save(kept, truth)
    rows = []
    for across in body['across']:
        x, numbers, report = run(program, statics, mesh, body['thick'] / across, body['words'], folder,
                                 True)
        # over the run: rms of the frames' rms, largest of their largest
        true = [size_of(a - b) for a, b in zip(x[1:], truth[1:])]
        together = lambda pairs: (math.sqrt(sum(p[0] ** 2 for p in pairs) / len(pairs)),
                                  max(p[1] for p in pairs))
        wrong, number = together(true), together([(n['rms'], n['largest']) for n in numbers])
        ratios = sorted(n['rms'] / t[0] for n, t in zip(numbers, true) if t[0] > wrong[0] / 10)
        moved = numpy.abs(truth - truth[0]).max()
        untrusted = sum(not n['trusted'] for n in numbers)
        rows.append(number[0] / wrong[0])
        print(f'| {name} | {across} | {report["voxels"]} | {1e3 * moved:.3g} | {1e3 * wrong[0]:.3g} | '
              f'{1e3 * number[0]:.3g} | {number[0] / wrong[0]:.2f} | {number[1] / wrong[1]:.2f} | '
              + ('' if statics else f'{ratios[0]:.2f} ... {ratios[-1]:.2f} | ')
              + ('no' if untrusted else 'yes') + ' |', flush=True)
        if not untrusted:
            yield rows[-1]


def main():
    parser = argparse.ArgumentParser(description=__doc__.split('\n')[0])
    parser.add_argument('program')
    parser.add_argument('--set', choices=('studied', 'unseen', 'motion'), default='studied')
    parser.add_argument('--assets')
    parser.add_argument('--only', default='')
    parser.add_argument('--truths', help='folder where the fine solutions are kept')
    options = parser.parse_args()
    statics = options.set != 'motion'
    bodies = {'studied': studied, 'unseen': unseen, 'motion': moving}[options.set]()
    if options.assets:
        bodies = of_folder(options.assets)
    print('| body | voxels across | voxels | motion [mm] | true rms [mm] | number [mm] | ratio | of '
          'the largest | ' + ('' if statics else 'in frames | ') + 'trusted |')
    ratios = []
    for name, body in bodies.items():
        if options.only in name:
            with tempfile.TemporaryDirectory() as folder:
                ratios += study(options.program, name, body, statics, Path(folder), options.truths)
    within = lambda a, b: sum(a <= r <= b for r in ratios)
    print(f'\ntrusted: {len(ratios)}; within 3: {within(1 / 3, 3)}; in 0.33 ... 4.5: '
          f'{within(0.33, 4.5)}')


if __name__ == '__main__':
    main()
