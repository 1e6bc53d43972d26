// Vibrates a game pad as strongly as the texture under the pointer, from the JSON of `tactogram touch`.
//
//     tactogram touch runs/corduroy --material corduroy --out corduroy.json
//
// Needs the package Input System. Put the file into Assets, and the component on any object.

using System;
using System.Linq;
using UnityEngine;
using UnityEngine.InputSystem;

public class TactogramTexture : MonoBehaviour
{
    public TextAsset file;
    public float forceWhileTouching = 0.5f; // N; screens do not measure it

    const string Format = "tactogram-texture";
    const int Version = 1;
    const float MillimetresPerInch = 25.4f;
    const float UsualDpi = 96f;
    const float SmoothingSeconds = 0.03f;

    // The keys of the JSON, as JsonUtility wants them.
    [Serializable]
    public class Document
    {
        public string format;
        public int version;
        public string kind;
        public string along;
        public float vibration_step_mm;
        public Arrays arrays;
    }

    [Serializable]
    public class Arrays
    {
        public Numbers speeds;
        public Numbers forces;
        public Numbers vibration;
    }

    [Serializable]
    public class Numbers
    {
        public float[] values;
    }

    Document texture;
    float strongest;
    Vector2 place; // mm
    float path; // mm
    float speed; // mm/s

    void Start()
    {
        texture = JsonUtility.FromJson<Document>(file.text);
        enabled = texture.format == Format && texture.version == Version;
        if (enabled) strongest = texture.arrays.vibration.values.Max();
        else Debug.LogError($"{file.name}: expected a file of tactogram touch, version {Version}");
    }

    void Update()
    {
        Pointer pointer = Pointer.current;
        Gamepad pad = Gamepad.current;
        if (pointer == null || pad == null) return;
        float millimetres = MillimetresPerInch / (Screen.dpi > 0 ? Screen.dpi : UsualDpi);
        Vector2 now = pointer.position.ReadValue() * millimetres;
        float step = pointer.press.wasPressedThisFrame ? 0f : Vector2.Distance(now, place);
        place = now;
        path += step;
        float seconds = Mathf.Max(Time.unscaledDeltaTime, 1e-4f);
        speed += (1f - Mathf.Exp(-seconds / SmoothingSeconds)) * (step / seconds - speed);
        bool sliding = pointer.press.isPressed && speed >= 1f;
        float share = sliding ? AmplitudeAt(speed, forceWhileTouching) / strongest : 0f;
        // The file does not tell how the strength is divided between low and high frequencies.
        pad.SetMotorSpeeds(share, share);
    }

    // Amplitude of the sine with the texture's power, in its unit.
    float AmplitudeAt(float speed, float force)
    {
        float[] amplitudes = texture.arrays.vibration.values;
        if (texture.kind == "surface")
        {
            float along = texture.along == "x" ? place.x : texture.along == "y" ? place.y : path;
            return amplitudes[(int)(along / texture.vibration_step_mm) % amplitudes.Length];
        }
        int across = texture.arrays.forces.values.Length;
        (int i0, int i1, float u) = Node(speed, texture.arrays.speeds.values);
        (int j0, int j1, float w) = Node(force, texture.arrays.forces.values);
        float slower = Mathf.Lerp(amplitudes[i0 * across + j0], amplitudes[i0 * across + j1], w);
        float faster = Mathf.Lerp(amplitudes[i1 * across + j0], amplitudes[i1 * across + j1], w);
        return Mathf.Lerp(slower, faster, u);
    }

    // The nodes on both sides of a value, and its share of the way between them.
    static (int, int, float) Node(float value, float[] nodes)
    {
        int last = nodes.Length - 1;
        if (value <= nodes[0]) return (0, 0, 0f);
        if (value >= nodes[last]) return (last, last, 0f);
        int upper = Array.FindIndex(nodes, node => node > value);
        return (upper - 1, upper, (value - nodes[upper - 1]) / (nodes[upper] - nodes[upper - 1]));
    }

    void OnDisable()
    {
        Gamepad.current?.SetMotorSpeeds(0f, 0f);
    }
}
