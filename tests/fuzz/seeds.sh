#!/bin/sh
# SPDX-License-Identifier: Apache-2.0

# Makes a folder of seeds for each fuzz target, of the project's own files: seeds.sh FOLDER
set -eu
mkdir -p "$1/picture" "$1/comparison" "$1/gate" "$1/card" "$1/scene" "$1/mesh"
cp tests/gate.toml "$1/gate"
printf '{"pictures": [{"file": "cycles.exr", "floor": {"wholePercent": 1, "regionsPercent": [1, 2e0]}}]}' \
  > "$1/card/card.json"
for scene in cornell seed spheres metals; do
  cp reference_scenes/$scene/scene.xml "$1/scene/$scene.xml"
done
cp reference_scenes/stress/*.xml reference_scenes/stress/easy/*.xml "$1/scene"
printf '%s' '<scene version="3.0.0"><sensor type="perspective"><film type="hdrfilm"/></sensor>' \
  '<shape type="cube"><bsdf type="dielectric"><string name="int_ior" value="water"/>' \
  '<float name="ext_ior" value="1"/><rgb name="specular_transmittance" value="0.9"/></bsdf></shape>' \
  '<shape type="rectangle"><transform name="to_world"><translate z="1"/></transform></shape>' \
  '<shape type="sphere"><boolean name="flip_normals" value="true"/><bsdf type="dielectric"/></shape></scene>' \
  > "$1/scene/glass.xml"
cp reference_scenes/*/*.obj "$1/mesh"
ply() {
  printf 'ply\nformat %s 1.0\nelement vertex 3\nproperty float x\nproperty float y\n' "$1"
  printf 'property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n'
  printf "$2"
}
ply ascii '0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n' > "$1/mesh/ascii.ply"
ply binary_little_endian '\0\0\0\0\0\0\0\0\0\0\0\0\0\0\200?\0\0\0\0\0\0\0\0\0\0\0\0\0\0\200?\0\0\0\0\3\0\0\0\0\1\0\0\0\2\0\0\0' \
  > "$1/mesh/binary.ply"
small() { oiiotool reference_scenes/stress/caustic.exr "$@"; }
for format in png jpg tif hdr webp bmp tga ppm; do
  small --ch R,G,B --resize 5x4 -o "$1/picture/seed.$format"
done
printf 'Pf\n2 1\n-1.0\n\0\0\200?\0\0\0?' > "$1/picture/seed.pfm"
small --ch R,G,B,A=1 --resize 5x4 -d uint16 -o "$1/picture/alpha.png" -o "$1/picture/alpha.tif"
for compression in none rle zips zip piz pxr24 b44 b44a dwaa dwab; do
  small --resize 9x5 --compression $compression -o "$1/picture/$compression.exr"
done
small --resize 9x5 --tile 4 2 -o "$1/picture/tiles.exr"
small --resize 9x5 --dup --siappend -o "$1/picture/parts.exr"
small --resize 9x5 --origin +2+1 --fullsize 16x9+0+0 -d half -o "$1/picture/window.exr"
