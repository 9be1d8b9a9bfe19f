// POV-Ray: glass that is within another object, be it of nothing, reflects nothing on its inside.
//
// A pane of glass lies under a white sky and is looked at from straight above. With Within=1 there
// is a sphere around the pane that lets all light pass as it came, which should change nothing.
//
//   povray povray_glass_within.pov +W16 +H16 +FP16 File_Gamma=1 +WT1 -D +Oa.ppm
//   povray povray_glass_within.pov +W16 +H16 +FP16 File_Gamma=1 +WT1 -D +Ob.ppm Declare=Within=1
//   python3 -c "import array; v = array.array('H', open('a.ppm', 'rb').read()[-1536:]);
//   v.byteswap(); print(sum(v) / 768 / 65535, min(v) / 65535, max(v) / 65535)"   (in one line)
//
// Expected: a surface reflects R = (0.5 / 2.5)^2 = 0.04 of light that meets it straight, and the
// pane with all that goes to and fro in it 2 R / (1 + R) = 0.07692, both times.
//
// Measured with POV-Ray 3.7.0.10: 0.07692 without the sphere and 0.04000 with it, that is R: the
// lower surface lets all light out. It is the same if the sphere is hollow or refracts, if a box or
// a union of triangles is in its place, and if the camera is in it, too.
#version 3.7;
#ifndef (Within) #declare Within = 0; #end
global_settings { assumed_gamma 1 max_trace_level 30 adc_bailout 1e-6 }
camera { location <0.01, 3, 0.01> direction -y right 0.001 * x up 0.001 * z }

#declare Clear = finish { ambient 0 diffuse 0 }
box {
  <-0.6, -0.1, -0.6>, <0.6, 0.1, 0.6>
  pigment { rgb 1 filter 1 }
  finish { Clear reflection { 0, 1 fresnel on } conserve_energy }
  interior { ior 1.5 }
}
#if (Within)
  sphere { 0, 1 pigment { rgb 1 transmit 1 } finish { Clear } }
#end

polygon {  // the sky
  5, <-9, 9, -9>, <9, 9, -9>, <9, 9, 9>, <-9, 9, 9>, <-9, 9, -9>
  pigment { rgb 1 } finish { Clear emission 1 }
}
