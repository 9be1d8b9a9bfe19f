// SPDX-License-Identifier: Apache-2.0

// sunflow: from within a ball, its far side hides what is nearer, and all lamps.
//
// A matte ball of radius 1 that reflects a half, and a lamp without size and of intensity 1 in its middle, from where the
// camera looks; light is reflected once. The same with a flat wall at distance 1 in place of the ball. Then a ball that
// shows 0.25 around a small one, or a small square, that shows 1 and is right before the camera; the outer ball is
// named in two ways, one after the other, since sunflow orders what it tries by name.
//
//	java -cp /usr/share/java/sunflow.jar sunflow_ball.java
//
// Expected: 0.5 / pi = 0.1592 for ball and wall, and 1 for what is nearer.
//
// Measured with sunflow 0.07.3, Debian's 0.07.2.svn396:
//
//     lit: ball 0.0000, wall 0.1595
//     within 'room': near ball 1.0000, near square 1.0000
//     within 'far': near ball 0.2500, near square 0.2500
//
// The cause seems to be in Sphere.java: intersectPrimitive() asks whether the near one of two hits is beyond what was hit
// before. Where that one is behind the ray's start, the far one is taken without being asked. The wall's 0.2 % are another
// matter: ShadingState.java moves points off their surfaces by 0.001, whatever the scene's size.

import org.sunflow.SunflowAPI;
import org.sunflow.core.Display;
import org.sunflow.image.Color;
import org.sunflow.math.Matrix4;
import org.sunflow.math.Point3;
import org.sunflow.math.Vector3;
import org.sunflow.system.UI;

class SunflowBall {
  private static final int SIDE = 32;

  // The red of the picture's middle.
  private static class Middle implements Display {
    float value;

    public void imageBegin(int w, int h, int bucketSize) {}
    public void imagePrepare(int x, int y, int w, int h, int id) {}
    public void imageFill(int x, int y, int w, int h, Color c, float alpha) {}
    public void imageEnd() {}

    public void imageUpdate(int x, int y, int w, int h, Color[] data, float[] alpha) {
      value = data[(h / 2) * w + w / 2].getRGB()[0];
    }
  }

  private static void shader(SunflowAPI api, String name, String kind, String parameter, float grey) {
    api.parameter(parameter, null, grey, grey, grey);
    api.shader(name, kind);
  }

  private static void instance(SunflowAPI api, String name, String shader) {
    api.parameter("shaders", shader);
    api.instance(name + "_instance", name);
  }

  private static void ball(SunflowAPI api, String name, String shader, float depth, float radius) {
    api.geometry(name, "sphere");
    api.parameter("transform", Matrix4.translation(0, 0, -depth).multiply(Matrix4.scale(radius)));
    instance(api, name, shader);
  }

  private static void square(SunflowAPI api, String name, String shader, float depth, float half) {
    api.parameter("points", "point", "vertex",
        new float[] {-half, -half, -depth, half, -half, -depth, half, half, -depth, -half, half, -depth});
    api.parameter("triangles", new int[] {0, 1, 2, 0, 2, 3});
    api.geometry(name, "triangle_mesh");
    instance(api, name, shader);
  }

  private static float render(SunflowAPI api) {
    api.parameter("transform", Matrix4.lookAt(new Point3(0, 0, 0), new Point3(0, 0, -1), new Vector3(0, 1, 0)));
    api.parameter("fov", 1.0f);
    api.camera("camera", "pinhole");
    api.parameter("camera", "camera");
    api.parameter("resolutionX", SIDE);
    api.parameter("resolutionY", SIDE);
    api.options(SunflowAPI.DEFAULT_OPTIONS);
    Middle middle = new Middle();
    api.render(SunflowAPI.DEFAULT_OPTIONS, middle);
    return middle.value;
  }

  private static float lit(boolean isBall) {
    SunflowAPI api = new SunflowAPI();
    shader(api, "matte", "diffuse", "diffuse", 0.5f);
    if (isBall) ball(api, "thing", "matte", 0, 1);
    else square(api, "thing", "matte", 1, 0.5f);
    float power = (float) (4 * Math.PI);
    api.parameter("power", null, power, power, power);
    api.parameter("center", new Point3(0, 0, 0));
    api.light("lamp", "point");
    return render(api);
  }

  private static float nearer(boolean isBall, String room) {
    SunflowAPI api = new SunflowAPI();
    shader(api, "white", "constant", "color", 1);
    shader(api, "grey", "constant", "color", 0.25f);
    if (isBall) ball(api, "near", "white", 0.5f, 0.1f);
    else square(api, "near", "white", 0.5f, 0.1f);
    ball(api, room, "grey", 0, 1);
    return render(api);
  }

  public static void main(String[] arguments) {
    UI.verbosity(0);
    System.out.printf("lit: ball %.4f, wall %.4f%n", lit(true), lit(false));
    for (String room : new String[] {"room", "far"})
      System.out.printf("within '%s': near ball %.4f, near square %.4f%n", room, nearer(true, room), nearer(false, room));
  }
}
