// POV-Ray: with 'count N, M' and M just above N, radiosity errs alike at all points.
//
// M is the number of directions in the pool, of which every point takes the next N. With M just
// above N all points take the same ones. With M far above N, points differ, and their mean is
// right.
//
// An endless wall of radiance 1 and height 1 stands on a white floor. The picture shows a tiny
// square of the floor, 1 away from the wall, and radiosity is told to gather anew in every pixel.
//
//   povray povray_count.pov +W16 +H16 +FP16 File_Gamma=1 +WT1 -D +Oa.ppm Declare=Pool=1511
//   python3 -c "import array; v = array.array('H', open('a.ppm', 'rb').read()[-1536:]);
//   v.byteswap(); print(sum(v) / 768 / 65535, min(v) / 65535, max(v) / 65535)"   (in one line)
//
// Expected: (1 - d / sqrt(d^2 + h^2)) / 2 = 0.146447.
//
// Measured with POV-Ray 3.7.0.10, 256 gatherings each:
//
//   N (Count)  M (Pool)   mean                       lowest to highest
//      200        211    .13268, -9.40 % +- 0.26 %   .1100 to .1400, all too low
//      200    100,003    .14653, +0.05 % +- 0.33 %   .1300 to .1700
//    1,500      1,511    .13831, -5.55 % +- 0.04 %   .1340 to .1393, all too low
//    1,500      1,600    .14500, -0.99 % +- 0.03 %   .1433 to .1460, all too low
//    1,500    100,003    .14648, +0.02 % +- 0.08 %   .1420 to .1520
//    5,000      5,003    .14692, +0.32 % +- 0.01 %   .1466 to .1472, all too high
//    5,000    100,003    .14647, +0.01 % +- 0.03 %   .1450 to .1480
//
// When all points err alike, interpolating between them can't average it out.
#version 3.7;
#ifndef (Count) #declare Count = 1500; #end
#ifndef (Pool) #declare Pool = 1511; #end
#declare Height = 1;
#declare Distance = 1;
global_settings {
  assumed_gamma 1
  radiosity {
    count Count, Pool
    recursion_limit 1 always_sample on
    error_bound 0.01 nearest_count 1 minimum_reuse 1e-6 maximum_reuse 1e-5
    pretrace_start 1 pretrace_end 1
  }
}
camera {
  orthographic location <0, 0.5, -Distance> look_at <0, 0, -Distance>
  right 1e-3 * x up 1e-3 * z
}
plane { y, 0 pigment { rgb 1 } finish { ambient 0 diffuse 1 } }
box { <-1e4, 0, 0>, <1e4, Height, 1> pigment { rgb 1 } finish { ambient 0 diffuse 0 emission 1 } }
