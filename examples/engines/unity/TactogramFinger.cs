// Sends the pointer (a finger, or the mouse with its button down) to `tactogram stream --motion osc`.
//
// Put it on any object. One message a frame, even while nothing moves: 100 ms of silence is a lost finger.

using UnityEngine;

public class TactogramFinger : MonoBehaviour
{
    public string host = "127.0.0.1";
    public int port = 9120;
    public string texture = "corduroy"; // a name in `--mix`; empty: leave the mix alone
    public float forceWhileTouching = 0.5f; // N; screens do not measure it

    const float MillimetresPerInch = 25.4f;
    const float UsualDpi = 96f;

    TactogramOsc osc;

    void Start()
    {
        Application.targetFrameRate = 120; // the stream wants 100 messages a second or more
        Application.runInBackground = true;
        osc = new TactogramOsc(host, port);
        if (texture != "") osc.SendMix(Time.realtimeSinceStartupAsDouble, texture, 1f);
    }

    void Update()
    {
        bool touching = Input.touchCount > 0 || Input.GetMouseButton(0);
        Vector2 pixels = Input.touchCount > 0 ? Input.GetTouch(0).position : (Vector2)Input.mousePosition;
        float millimetres = MillimetresPerInch / (Screen.dpi > 0 ? Screen.dpi : UsualDpi);
        osc.SendMotion(
            Time.realtimeSinceStartupAsDouble,
            pixels.x * millimetres,
            pixels.y * millimetres,
            float.NaN, // the stream finds the speed from the positions
            touching ? forceWhileTouching : 0f);
    }

    void OnDestroy()
    {
        osc?.Dispose();
    }
}
