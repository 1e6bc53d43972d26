// OSC messages to `tactogram stream --motion osc`: docs/streaming.md, schema version 1. No dependency, no Unity.

using System;
using System.IO;
using System.Net.Sockets;
using System.Text;

public sealed class TactogramOsc : IDisposable
{
    public const string MotionAddress = "/tactogram/1/motion", MotionTypes = ",idffff";
    public const string TapAddress = "/tactogram/1/tap", TapTypes = ",idf";
    public const string MixAddress = "/tactogram/1/mix", MixTypes = ",idsf";

    readonly UdpClient client;
    int sequence;

    public TactogramOsc(string host = "127.0.0.1", int port = 9120)
    {
        client = new UdpClient(host, port);
    }

    // Seconds on the sender's clock, mm, mm/s and N; NaN marks what is not known.
    public void SendMotion(double time, float x, float y, float speed = float.NaN, float force = float.NaN)
    {
        Send(Message(MotionAddress, MotionTypes, sequence, time, x, y, speed, force));
    }

    // Strength 1 is a landing of 1 N.
    public void SendTap(double time, float strength)
    {
        Send(Message(TapAddress, TapTypes, sequence, time, strength));
    }

    // Weight of a texture, by the name that the stream knows it by.
    public void SendMix(double time, string name, float weight)
    {
        Send(Message(MixAddress, MixTypes, sequence, time, name, weight));
    }

    public static byte[] Message(string address, string types, params object[] values)
    {
        using (var stream = new MemoryStream())
        {
            WriteText(stream, address);
            WriteText(stream, types);
            foreach (object value in values)
            {
                if (value is string text) WriteText(stream, text);
                else if (value is int whole) WriteBigEndian(stream, BitConverter.GetBytes(whole));
                else if (value is float single) WriteBigEndian(stream, BitConverter.GetBytes(single));
                else WriteBigEndian(stream, BitConverter.GetBytes((double)value));
            }
            return stream.ToArray();
        }
    }

    public void Dispose()
    {
        client.Dispose();
    }

    void Send(byte[] packet)
    {
        unchecked { sequence++; } // of every message, of any kind; wraps
        try
        {
            client.Send(packet, packet.Length);
        }
        catch (SocketException)
        {
            // No stream listens (yet): the next message may arrive.
        }
    }

    // A text ends with one to four zeros, so that its length is a multiple of four.
    static void WriteText(Stream stream, string text)
    {
        byte[] bytes = Encoding.UTF8.GetBytes(text);
        stream.Write(bytes, 0, bytes.Length);
        stream.Write(new byte[4], 0, 4 - bytes.Length % 4);
    }

    static void WriteBigEndian(Stream stream, byte[] bytes)
    {
        if (BitConverter.IsLittleEndian) Array.Reverse(bytes);
        stream.Write(bytes, 0, bytes.Length);
    }
}
