// POV-Ray: to the rays that radiosity sends out, an area_light is one point in its middle.
//
// An area_light of two points shines on a white floor: both 60 degrees from the vertical, one to
// the left, one to the right. A white wall stands on the floor, parallel to all that light, so
// that it gets none of it directly. The picture shows the wall. With Separate=1 the two points
// are two light_sources of half the brightness each, which should change nothing.
//
//   povray povray_area_light.pov +W16 +H16 +FP16 File_Gamma=1 +WT1 -D +Oa.ppm
//   povray povray_area_light.pov +W16 +H16 +FP16 File_Gamma=1 +WT1 -D +Ob.ppm Declare=Separate=1
//   python3 -c "import array; v = array.array('H', open('a.ppm', 'rb').read()[-1536:]);
//   v.byteswap(); print(sum(v) / 768 / 65535, min(v) / 65535, max(v) / 65535)"   (in one line)
//
// Expected: the floor's radiance is cos 60 = 0.5. It fills half of what a point of the wall sees,
// in projected solid angle. So the wall's radiance is 0.25, both times.
//
// Measured with POV-Ray 3.7.0.10: 0.4995 with the area_light and 0.2497 with two lights. The
// middle of the area_light stands vertically above the floor, where cos 0 = 1. (The missing
// 0.1 % is the error of 1,000 directions.) In the Cornell box with its square lamp, indirect light
// was 24.5 % too bright.
//
// It seems to be meant so: radiosity.cpp switches area lights off for these rays. What is missing
// is a setting that switches them on.
#version 3.7;
#ifndef (Separate) #declare Separate = 0; #end
global_settings {
  assumed_gamma 1
  radiosity { count 1000, 100003 recursion_limit 1 always_sample on }
}
camera { orthographic location <0, 1, 9> look_at <0, 1, 0> right x up y }
#default { texture { pigment { rgb 1 } finish { ambient 0 diffuse 1 } } }

plane { y, 0 }  // the floor, not in the picture
plane { z, 0 }  // the wall, all of the picture

// As far away as the sun, so that their light has the same angle everywhere.
#declare Far = 1e5;
#declare Lamp = <0, Far, 0>;
#declare Aside = <sqrt(3) * Far, 0, 0>;
#if (Separate)
  light_source { Lamp - Aside rgb 0.5 }
  light_source { Lamp + Aside rgb 0.5 }
#else
  light_source { Lamp rgb 1 area_light 2 * Aside, z, 2, 1 area_illumination on }
#end
