#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0

# How often `plumb compare` calls honest renders different, and which faults it finds from how many
# samples per pixel on: the tables of docs/compare.md.
#   bench/compare_study.sh build/plumb [PAIRS [FOLDER]]
# Renders are kept in the folder, if one is given, for the next time.
set -euo pipefail

plumb=$(realpath "$1")
pairs=${2:-2000}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
renders=$(realpath "${3:-$work}")
cd "$(dirname "$0")/.."

# render FILE SCENE SPP SEED [SAMPLER]
render() {
  [[ -f $1 ]] || "$plumb" render "$2" --spp "$3" --seed "$4" --sampler "${5:-sobol}" -o "$1" \
    >"$work/log" 2>&1
}

# compare TEST REFERENCE OPTIONS...: the verdict
compare() {
  local code=0
  "$plumb" compare "$@" >"$work/report" || code=$?
  case $code in 0) echo same ;; 1) echo different ;; 3) echo inconclusive ;; *) return "$code" ;; esac
}

pick() { shift $((RANDOM % $#)) && echo "$1"; }

readonly seeds=40

render_pool() {
  for scene in cornell seed; do
    for sampler in sobol independent; do
      for spp in 16 64 256; do
        for ((k = 1; k <= seeds; ++k)); do
          render "$renders/$scene-$sampler-$spp-$k.exr" "reference_scenes/$scene/scene.xml" "$spp" \
            $((1000 * k + spp)) "$sampler"
        done
      done
    done
  done
}

# Pairs of the same scene, with any samplers and numbers of samples, but never the same seed.
false_alarms() {
  render_pool
  for tolerance in 0 1%; do
    RANDOM=1
    for ((pair = 0; pair < pairs; ++pair)); do
      scene=$(pick cornell seed)
      k=$((RANDOM % seeds + 1))
      echo "[[compare]]"
      for side in test reference; do
        echo "$side = '$renders/$scene-$(pick sobol independent)-$(pick 16 64 256)-$k.exr'"
        k=$((k % seeds + 1))
      done
      echo "tolerance = '$tolerance'"
    done >"$work/gate.toml"
    echo "Tolerance $tolerance:"
    { "$plumb" compare --gate "$work/gate.toml" || true; } | sed -E 's/^.*exr: ([a-z]*):.*/\1/' | sort | uniq -c
  done
}

# fault NAME SED_EXPRESSION: edits the Cornell box.
fault() {
  sed -e "$2" reference_scenes/cornell/scene.xml >"$work/scenes/$1.xml"
}

make_faults() {
  mkdir "$work/scenes"
  cp reference_scenes/cornell/*.obj "$work/scenes"
  fault lamp_0.5%_brighter 's/17, 12, 4/17.085, 12.06, 4.02/'
  fault left_wall_1%_redder 's/0.63, 0.065/0.6363, 0.065/'
  fault half_a_pixel_aside 's/"278, 273/"279.9, 273/g'
  fault short_block_mirrored 's/short_block.obj/mirrored.obj/'
  awk '/^v/ { $2 = 371 - $2 } /^f/ { s = "f"; for (i = NF; i > 1; --i) s = s " " $i; $0 = s } 1' \
    reference_scenes/cornell/short_block.obj >"$work/scenes/mirrored.obj"
  local spot='<shape type="rectangle" id="spot"><transform name="to_world"><scale value="5.7"/>'
  spot+='<rotate y="1" angle="180"/><translate x="400" y="420" z="559"/></transform>'
  fault spot_of_3x3_pixels_20%_brighter \
    "s|</scene>|$spot<bsdf type=\"diffuse\"><rgb name=\"reflectance\" value=\"0.876\"/></bsdf></shape>&|"
}

# The lamp is left out: it has no noise, and would show every change of its radiance at once.
power() {
  make_faults
  local seed=0 below_the_lamp=0,60,256,196
  "$plumb" render reference_scenes/cornell/scene.xml --aov object -o "$work/objects.png" >"$work/log"
  for spp in 16 64 256 1024; do
    rm -f "$work/reference.exr"
    render "$work/reference.exr" reference_scenes/cornell/scene.xml "$spp" $((++seed))
    for scene in "$work"/scenes/*.xml; do
      rm -f "$work/fault.exr"
      render "$work/fault.exr" "$scene" "$spp" 1000
      compare "$work/fault.exr" "$work/reference.exr" --other-scene --tolerance 0 \
        --crop "$below_the_lamp" --regions "$work/objects.png" >"$work/verdict"
      echo "$spp spp, $(basename "$scene" .xml): $(grep "^$(cat "$work/verdict"):" "$work/report")"
    done
  done
}

echo "False alarms in $pairs pairs"
false_alarms
echo "Power"
power
