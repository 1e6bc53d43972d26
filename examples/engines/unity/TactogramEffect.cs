// Plays JSON that `tactogram convert` wrote: gamepad effects on a pad, Android's envelope on a phone (Android 16).
//
//     tactogram convert denim.wav denim.json --format gamepad
//     tactogram convert denim.wav denim.json --format android_envelope
//
// Needs the package Input System for pads. Put the file into Assets, and the component on any object.

using System;
using System.Collections;
using UnityEngine;
using UnityEngine.InputSystem;

public class TactogramEffect : MonoBehaviour
{
    public TextAsset file;

    // The keys of the JSON, as JsonUtility wants them.
    [Serializable]
    public class Document
    {
        public string format;
        public Effect[] effects;
        public float initialFrequencyHz;
        public ControlPoint[] controlPoints;
    }

    [Serializable]
    public class Effect
    {
        public float startDelay;
        public float duration;
        public float strongMagnitude;
        public float weakMagnitude;
    }

    [Serializable]
    public class ControlPoint
    {
        public float amplitude;
        public float frequencyHz;
        public long durationMillis;
    }

    public void Play()
    {
        Document document = JsonUtility.FromJson<Document>(file.text);
        if (document.format == "gamepad-effects") StartCoroutine(PlayOnPad(document));
        else if (document.format == "android-waveform-envelope") PlayOnPhone(document);
        else Debug.LogError($"{file.name}: expected gamepad or android_envelope, got {document.format}");
    }

    static IEnumerator PlayOnPad(Document document)
    {
        Gamepad pad = Gamepad.current;
        if (pad == null) yield break;
        foreach (Effect effect in document.effects)
        {
            if (effect.startDelay > 0)
            {
                pad.SetMotorSpeeds(0f, 0f);
                yield return new WaitForSecondsRealtime(effect.startDelay / 1000f);
            }
            pad.SetMotorSpeeds(effect.strongMagnitude, effect.weakMagnitude); // low frequency, high frequency
            yield return new WaitForSecondsRealtime(effect.duration / 1000f);
        }
        pad.SetMotorSpeeds(0f, 0f);
    }

    static void PlayOnPhone(Document document)
    {
#if UNITY_ANDROID && !UNITY_EDITOR
        using (var player = new AndroidJavaClass("com.unity3d.player.UnityPlayer"))
        using (var activity = player.GetStatic<AndroidJavaObject>("currentActivity"))
        using (var vibrator = activity.Call<AndroidJavaObject>("getSystemService", "vibrator"))
        {
            if (!vibrator.Call<bool>("areEnvelopeEffectsSupported"))
            {
                Debug.LogWarning("This phone has no envelopes: convert with --format android");
                return;
            }
            using (var builder = new AndroidJavaObject("android.os.VibrationEffect$WaveformEnvelopeBuilder"))
            {
                builder.Call<AndroidJavaObject>("setInitialFrequencyHz", document.initialFrequencyHz);
                foreach (ControlPoint point in document.controlPoints)
                    builder.Call<AndroidJavaObject>(
                        "addControlPoint", point.amplitude, point.frequencyHz, point.durationMillis);
                using (var effect = builder.Call<AndroidJavaObject>("build")) vibrator.Call("vibrate", effect);
            }
        }
#endif
    }

    void OnDisable()
    {
        Gamepad.current?.SetMotorSpeeds(0f, 0f);
    }
}
