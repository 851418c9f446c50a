"""Meshes of the zero surfaces of fields that are negative inside and have a gradient near 1.

The surface is found by surface nets (Gibson 1998) on a regular grid of which only what is near the surface is looked at,
with a vertex for each sheet in a cell (Nielson 2004); vertices are then moved onto the surface.
"""
import math

BLOCK = 8  # cells along a block's side that is skipped as a whole


def ellipsoid(p, centre, radii):
    """A bound of the distance (Quilez)."""
    x, y, z = p[0] - centre[0], p[1] - centre[1], p[2] - centre[2]
    a, b, c = radii
    near = math.sqrt((x / a) ** 2 + (y / b) ** 2 + (z / c) ** 2)
    steep = math.sqrt((x / (a * a)) ** 2 + (y / (b * b)) ** 2 + (z / (c * c)) ** 2)
    return near * (near - 1.0) / steep if steep > 1e-12 else -min(radii)


def capsule(p, a, b, ra, rb):
    dx, dy, dz = b[0] - a[0], b[1] - a[1], b[2] - a[2]
    px, py, pz = p[0] - a[0], p[1] - a[1], p[2] - a[2]
    t = max(0.0, min(1.0, (px * dx + py * dy + pz * dz) / (dx * dx + dy * dy + dz * dz)))
    return math.sqrt((px - t * dx) ** 2 + (py - t * dy) ** 2 + (pz - t * dz) ** 2) - (ra + t * (rb - ra))


def union(a, b, k):
    """Blended over the length k."""
    h = max(k - abs(a - b), 0.0) / k
    return min(a, b) - h * h * k * 0.25


def without(a, b, k):
    return -union(-a, b, k)


def gradient(field, p, step=1e-4):
    x, y, z = p
    g = (
        field(x + step, y, z) - field(x - step, y, z),
        field(x, y + step, z) - field(x, y - step, z),
        field(x, y, z + step) - field(x, y, z - step),
    )
    size = math.sqrt(g[0] * g[0] + g[1] * g[1] + g[2] * g[2])
    return [c / size for c in g], size / (2.0 * step)


def samples(field, lower, upper, cells):
    """Values at grid points near the surface, by index; far ones are left out."""
    size = max(u - l for l, u in zip(lower, upper)) / cells
    counts = [math.ceil((u - l) / size / BLOCK) * BLOCK for l, u in zip(lower, upper)]
    at = lambda i: tuple(l + k * size for l, k in zip(lower, i))
    # Blends and bounds are off by far less than this factor.
    far = 1.6 * BLOCK * size * math.sqrt(3.0) / 2.0
    values = {}
    for bi in range(0, counts[0], BLOCK):
        for bj in range(0, counts[1], BLOCK):
            for bk in range(0, counts[2], BLOCK):
                middle = at((bi + BLOCK / 2, bj + BLOCK / 2, bk + BLOCK / 2))
                if abs(field(*middle)) > far:
                    continue
                for i in range(bi, bi + BLOCK + 1):
                    for j in range(bj, bj + BLOCK + 1):
                        for k in range(bk, bk + BLOCK + 1):
                            if (i, j, k) not in values:
                                values[i, j, k] = field(*at((i, j, k)))
    return values, at


CORNERS = [(i, j, k) for i in (0, 1) for j in (0, 1) for k in (0, 1)]
# A cell's edges as (lower end, axis), and the edges and corners round each of its faces, in order.
AXES = [tuple(1 if k == axis else 0 for k in range(3)) for axis in range(3)]


def plus(*vectors):
    return tuple(sum(c) for c in zip(*vectors))


EDGES = [(corner, axis) for axis in range(3) for corner in CORNERS if corner[axis] == 0]


def faces():
    for axis in range(3):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        for base in ((0, 0, 0), AXES[axis]):
            corners = [base, plus(base, AXES[u]), plus(base, AXES[u], AXES[v]), plus(base, AXES[v])]
            edges = [(base, u), (corners[1], v), (corners[3], u), (base, v)]
            yield corners, edges


FACES = list(faces())


def sheets(inside):
    """The crossed edges of a cell, one list for each sheet of the surface in it: what is inside is kept apart."""
    crossed = [e for e in EDGES if inside[e[0]] != inside[plus(e[0], AXES[e[1]])]]
    group = {edge: edge for edge in crossed}

    def root(edge):
        while group[edge] != edge:
            edge = group[edge]
        return edge

    for corners, edges in FACES:
        cut = [edge for edge in edges if edge in group]
        if len(cut) == 2:
            group[root(cut[0])] = root(cut[1])
        elif len(cut) == 4:
            # Edge k leads from corner k to the next: about each corner inside, the edges before and after it.
            for k in range(4):
                if inside[corners[k]]:
                    group[root(edges[k - 1])] = root(edges[k])
    parts = {}
    for edge in crossed:
        parts.setdefault(root(edge), []).append(edge)
    return list(parts.values())


def on_surface(field, p):
    for _ in range(4):
        normal, slope = gradient(field, p)
        step = field(*p) / max(slope, 0.3)
        p = [c - step * n for c, n in zip(p, normal)]
    return p


def mesh(field, lower, upper, cells):
    values, at = samples(field, lower, upper, cells)
    places, vertices = {}, []
    for cell in values:
        corners = {corner: plus(cell, corner) for corner in CORNERS}
        if any(corner not in values for corner in corners.values()):
            continue
        inside = {offset: values[corner] < 0.0 for offset, corner in corners.items()}
        if all(inside.values()) or not any(inside.values()):
            continue
        for sheet in sheets(inside):
            sums = [0.0, 0.0, 0.0]
            for offset, axis in sheet:
                a, b = plus(cell, offset), plus(cell, offset, AXES[axis])
                t = values[a] / (values[a] - values[b])
                sums = [s + u + t * (v - u) for s, u, v in zip(sums, at(a), at(b))]
                places[cell, offset, axis] = len(vertices)
            vertices.append([s / len(sheet) for s in sums])
    triangles = []
    for point, value in values.items():
        for axis in range(3):
            other = plus(point, AXES[axis])
            if other not in values or (value < 0.0) == (values[other] < 0.0):
                continue
            u, v = AXES[(axis + 1) % 3], AXES[(axis + 2) % 3]
            offsets = [(0, 0, 0), u, plus(u, v), v]
            ring = [places[tuple(p - o for p, o in zip(point, offset)), offset, axis] for offset in offsets]
            if value >= 0.0:
                ring.reverse()
            a, b, c, d = ring
            # The shorter diagonal.
            if math.dist(vertices[a], vertices[c]) <= math.dist(vertices[b], vertices[d]):
                triangles += [(a, b, c), (a, c, d)]
            else:
                triangles += [(b, c, d), (b, d, a)]
    return vertices, triangles


def is_closed(triangles):
    """Whether every edge is between two triangles that agree about its way."""
    seen = {}
    for triangle in triangles:
        for edge in zip(triangle, triangle[1:] + triangle[:1]):
            seen[edge] = seen.get(edge, 0) + 1
    return all(count == 1 and (b, a) in seen for (a, b), count in seen.items())


def welded(rows, triangles):
    """Without vertices that are written alike, and what loses its area by that."""
    first = {}
    number = [first.setdefault(row, len(first)) for row in rows]
    triangles = [tuple(number[i] for i in triangle) for triangle in triangles]
    return list(first), [triangle for triangle in triangles if len(set(triangle)) == 3]


def closed_mesh(field, lower, upper, cells):
    """The surface as rows of an OBJ file, triangles of the rows' numbers from 0, and how many cells along the longest side
    it took: `cells`, or fewer.
    """
    # Where two sheets touch twice in neighbouring cells, four triangles meet in an edge: rare, gone on another grid.
    vertices, triangles = mesh(field, lower, upper, cells)
    while not is_closed(triangles):
        cells -= 1
        vertices, triangles = mesh(field, lower, upper, cells)
    rows = ["v " + " ".join(f"{c:.4f}" for c in on_surface(field, p)) for p in vertices]
    return *welded(rows, triangles), cells
