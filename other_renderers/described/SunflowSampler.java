// SPDX-License-Identifier: Apache-2.0

// Draws a scene with sunflow, by independent samples, into floats. Debian's sunflow reads no scene files: the lines of a
// scene are calls of its interface, "KIND NAME COUNT VALUES" for a parameter and "VERB NAME [TYPE]" for what takes those
// before it.
//
//	java -cp sunflow.jar SunflowSampler.java SCENE.txt OUT.pfm SPP SEED

import java.io.IOException;
import java.io.UncheckedIOException;
import java.nio.ByteBuffer;
import java.nio.ByteOrder;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.Arrays;
import java.util.SplittableRandom;
import java.util.stream.IntStream;
import org.sunflow.PluginRegistry;
import org.sunflow.SunflowAPI;
import org.sunflow.core.Display;
import org.sunflow.core.ImageSampler;
import org.sunflow.core.IntersectionState;
import org.sunflow.core.Options;
import org.sunflow.core.ParameterList;
import org.sunflow.core.Scene;
import org.sunflow.core.ShadingState;
import org.sunflow.core.display.FileDisplay;
import org.sunflow.core.light.TriangleMeshLight;
import org.sunflow.core.shader.DiffuseShader;
import org.sunflow.image.Color;
import org.sunflow.math.Matrix4;
import org.sunflow.math.Point3;
import org.sunflow.math.Vector3;
import org.sunflow.system.UI;

public class SunflowSampler implements ImageSampler {
  // Black on its back, as sunflow's own is not.
  public static class OneSided extends DiffuseShader {
    @Override
    public Color getRadiance(ShadingState state) {
      return front(state, getDiffuse(state));
    }
  }

  // sunflow's own lamps reflect nothing.
  public static class ReflectingLamp extends TriangleMeshLight {
    private Color reflectance;
    private Color radiance;

    @Override
    public boolean update(ParameterList parameters, SunflowAPI api) {
      reflectance = parameters.getColor("diffuse", reflectance);
      radiance = parameters.getColor("radiance", radiance);
      return super.update(parameters, api);
    }

    @Override
    public Color getRadiance(ShadingState state) {
      Color reflected = front(state, reflectance);
      return state.isBehind() || !state.includeLights() ? reflected : reflected.copy().add(radiance);
    }
  }

  private static Color front(ShadingState state, Color reflectance) {
    state.faceforward();
    if (state.isBehind()) return Color.BLACK;
    state.initLightSamples();
    return state.diffuse(reflectance);
  }

  private static final int FIRST_DIMENSION = 4; // as sunflow's own samplers have it

  private static Path output;
  private static int spp;
  private static long seed;

  private Scene scene;
  private int width;
  private int height;

  public boolean prepare(Options options, Scene scene, int width, int height) {
    this.scene = scene;
    this.width = width;
    this.height = height;
    return true;
  }

  public void render(Display display) {
    long begin = System.nanoTime();
    float[] picture = new float[3 * width * height];
    IntStream.range(0, height).parallel().forEach(y -> renderRow(y, picture));
    double seconds = 1e-9 * (System.nanoTime() - begin);
    try {
      write(picture);
    } catch (IOException trouble) {
      throw new UncheckedIOException(trouble);
    }
    System.out.println("plumbline: {\"version\": \"" + SunflowAPI.VERSION + "\", \"seconds\": " + seconds + "}");
  }

  // Rows go up from the lowest, in sunflow's places as in PFM.
  private void renderRow(int y, float[] picture) {
    SplittableRandom random = new SplittableRandom(seed * height + y);
    IntersectionState state = new IntersectionState();
    for (int x = 0; x < width; ++x) {
      double[] sum = new double[3];
      for (int sample = 0; sample < spp; ++sample) {
        // Halton's sequence begins at a random place for each sample, so these are independent.
        var shaded = scene.getRadiance(state, (float) (x + random.nextDouble()),
            (float) (y + random.nextDouble()), 0.5, 0.5, 0.5, random.nextInt(1 << 30), FIRST_DIMENSION, null);
        if (shaded == null) continue;
        float[] rgb = shaded.getResult().getRGB();
        for (int channel = 0; channel < 3; ++channel) sum[channel] += rgb[channel];
      }
      for (int channel = 0; channel < 3; ++channel)
        picture[3 * (y * width + x) + channel] = (float) (sum[channel] / spp);
    }
  }

  private void write(float[] picture) throws IOException {
    byte[] header = String.format("PF\n%d %d\n-1.0\n", width, height).getBytes();
    ByteBuffer bytes = ByteBuffer.allocate(header.length + 4 * picture.length).order(ByteOrder.LITTLE_ENDIAN);
    bytes.put(header);
    bytes.asFloatBuffer().put(picture);
    Files.write(output, bytes.array());
  }

  private static void call(SunflowAPI api, String[] words) {
    switch (words[0]) {
      case "shader" -> api.shader(words[1], words[2]);
      case "geometry" -> api.geometry(words[1], words[2]);
      case "instance" -> api.instance(words[1], words[2]);
      case "light" -> api.light(words[1], words[2]);
      case "camera" -> api.camera(words[1], words[2]);
      case "options" -> api.options(SunflowAPI.DEFAULT_OPTIONS);
      case "string" -> api.parameter(words[1], words[3]);
      case "int" -> ints(api, words[1], Arrays.stream(words).skip(3).mapToInt(Integer::parseInt).toArray());
      default -> floats(api, words[0], words[1], Arrays.stream(words).skip(3).map(Float::valueOf).toArray(Float[]::new));
    }
  }

  private static void ints(SunflowAPI api, String name, int[] values) {
    if (values.length == 1) api.parameter(name, values[0]);
    else api.parameter(name, values);
  }

  private static void floats(SunflowAPI api, String kind, String name, Float[] boxed) {
    float[] v = new float[boxed.length];
    for (int i = 0; i < v.length; ++i) v[i] = boxed[i];
    switch (kind) {
      case "float" -> api.parameter(name, v[0]);
      case "color" -> api.parameter(name, null, v);
      case "point" -> api.parameter(name, new Point3(v[0], v[1], v[2]));
      case "points" -> api.parameter(name, "point", "vertex", v);
      case "ball" -> api.parameter(name, Matrix4.translation(v[0], v[1], v[2]).multiply(Matrix4.scale(v[3])));
      case "look_at" -> api.parameter(name, Matrix4.lookAt(new Point3(v[0], v[1], v[2]), new Point3(v[3], v[4], v[5]),
          new Vector3(v[6], v[7], v[8])));
      default -> throw new IllegalArgumentException(kind);
    }
  }

  public static void main(String[] arguments) throws IOException {
    output = Path.of(arguments[1]);
    spp = Integer.parseInt(arguments[2]);
    seed = Long.parseLong(arguments[3]);
    UI.verbosity(2);
    PluginRegistry.imageSamplerPlugins.registerPlugin("independent", SunflowSampler.class);
    PluginRegistry.shaderPlugins.registerPlugin("one_sided", OneSided.class);
    PluginRegistry.lightSourcePlugins.registerPlugin("reflecting_lamp", ReflectingLamp.class);
    SunflowAPI api = new SunflowAPI();
    for (String line : Files.readAllLines(Path.of(arguments[0]))) call(api, line.split(" "));
    api.parameter("sampler", "independent");
    api.options(SunflowAPI.DEFAULT_OPTIONS);
    api.render(SunflowAPI.DEFAULT_OPTIONS, new FileDisplay(false));
  }
}
