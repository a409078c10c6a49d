"""Runs filters of MeshLab for `cargo xtask bench`.

meshlab.py probe                          exits with 0 when pymeshlab can be used
meshlab.py quadrics IN.ply FOLDER N...    for each N: FOLDER/N.positions (f32) and FOLDER/N.faces (u32), little-endian
meshlab.py nexus IN.ply OUT.nxs           prints the seconds that the Nexus builder took
"""

import sys
import time

import pymeshlab


def quadrics(source, folder, counts):
    for count in counts:
        meshes = pymeshlab.MeshSet(verbose=False)
        meshes.load_new_mesh(source)
        # Every parameter is given: a filter remembers those of its last call.
        meshes.meshing_decimation_quadric_edge_collapse(
            targetfacenum=int(count),
            targetperc=0.0,
            qualitythr=0.3,
            preserveboundary=False,
            boundaryweight=1.0,
            preservenormal=False,
            preservetopology=False,
            optimalplacement=True,
            planarquadric=False,
            planarweight=0.001,
            qualityweight=False,
            autoclean=True,
            selected=False,
        )
        mesh = meshes.current_mesh()
        mesh.vertex_matrix().astype("<f4").tofile(f"{folder}/{count}.positions")
        mesh.face_matrix().astype("<u4").tofile(f"{folder}/{count}.faces")


def nexus(source, target):
    meshes = pymeshlab.MeshSet(verbose=False)
    start = time.monotonic()
    meshes.nxs_build(input_file=source, output_file=target)
    print(time.monotonic() - start)


if __name__ == "__main__":
    if sys.argv[1] == "quadrics":
        quadrics(sys.argv[2], sys.argv[3], sys.argv[4:])
    elif sys.argv[1] == "nexus":
        nexus(sys.argv[2], sys.argv[3])
