// SPDX-License-Identifier: Apache-2.0

// Renders a plain scene (docs/plain-scene.md) with the path tracer github.com/fogleman/pt.
//
//	fogleman_pt SCENE.json OUT.pfm SPP BOUNCES
package main

import (
	"encoding/binary"
	"encoding/json"
	"fmt"
	"math"
	"os"
	"strconv"

	"github.com/fogleman/pt/pt"
)

type vector [3]float64

type plainScene struct {
	Camera struct {
		Width, Height int
		Matrix        [4][4]float64 `json:"camera_to_world"`
		HalfHeight    float64       `json:"half_height"`
	}
	Shapes []plainShape
	Sky    vector
}

type plainShape struct {
	Material struct {
		Kind        string
		Reflectance vector
		Ior         float64
	}
	Radiance  vector
	Triangles [][3]vector
	Sphere    *struct {
		Center vector
		Radius float64
	}
}

func (v vector) point() pt.Vector { return pt.Vector{X: v[0], Y: v[1], Z: v[2]} }
func (v vector) color() pt.Color  { return pt.Color{R: v[0], G: v[1], B: v[2]} }

// What a lamp reflects is its colour. A faint one with a strong emittance reflects next to nothing.
const faint = 1e-9

func materialOf(shape plainShape) pt.Material {
	if shape.Radiance != (vector{}) {
		return pt.LightMaterial(shape.Radiance.color().MulScalar(faint), 1/faint)
	}
	switch color := shape.Material.Reflectance.color(); shape.Material.Kind {
	case "glass":
		return pt.ClearMaterial(shape.Material.Ior, 0)
	case "metal":
		return pt.MetallicMaterial(color, 0, 1)
	default:
		return pt.DiffuseMaterial(color)
	}
}

func read(file string) (*pt.Scene, *pt.Camera, int, int) {
	var plain plainScene
	text, err := os.ReadFile(file)
	must(err)
	must(json.Unmarshal(text, &plain))
	scene := pt.Scene{Color: plain.Sky.color()}
	for _, shape := range plain.Shapes {
		material := materialOf(shape)
		if shape.Sphere != nil {
			scene.Add(pt.NewSphere(shape.Sphere.Center.point(), shape.Sphere.Radius, material))
		}
		for _, t := range shape.Triangles {
			scene.Add(pt.NewTriangle(t[0].point(), t[1].point(), t[2].point(), pt.Vector{}, pt.Vector{},
				pt.Vector{}, material))
		}
	}
	m := plain.Camera.Matrix
	place := vector{m[0][3], m[1][3], m[2][3]}.point()
	up := vector{m[0][1], m[1][1], m[2][1]}.point()
	ahead := vector{-m[0][2], -m[1][2], -m[2][2]}.point()
	degrees := 2 * math.Atan(plain.Camera.HalfHeight) * 180 / math.Pi
	camera := pt.LookAt(place, place.Add(ahead), up, degrees)
	return &scene, &camera, plain.Camera.Width, plain.Camera.Height
}

func write(file string, buffer *pt.Buffer) {
	out, err := os.Create(file)
	must(err)
	defer out.Close()
	fmt.Fprintf(out, "PF\n%d %d\n-1.0\n", buffer.W, buffer.H)
	for y := buffer.H - 1; y >= 0; y-- {
		for x := 0; x < buffer.W; x++ {
			c := buffer.Color(x, y)
			must(binary.Write(out, binary.LittleEndian, []float32{float32(c.R), float32(c.G), float32(c.B)}))
		}
	}
}

func must(err error) {
	if err != nil {
		fmt.Fprintln(os.Stderr, "Error:", err)
		os.Exit(1)
	}
}

func main() {
	scene, camera, width, height := read(os.Args[1])
	spp, err := strconv.Atoi(os.Args[3])
	must(err)
	bounces, err := strconv.Atoi(os.Args[4])
	must(err)
	renderer := pt.NewRenderer(scene, camera, pt.NewSampler(1, bounces), width, height)
	renderer.SamplesPerPixel = spp
	renderer.Verbose = false
	renderer.Render()
	write(os.Args[2], renderer.Buffer)
}
