# Sends the pointer (a finger, or the mouse with its button down) to `tactogram stream --motion osc`:
# docs/streaming.md, schema version 1. Godot 4; add it to any scene as a node.
extends Node

const MOTION_ADDRESS := "/tactogram/1/motion"
const MOTION_TYPES := ",idffff"
const MIX_ADDRESS := "/tactogram/1/mix"
const MIX_TYPES := ",idsf"
const MILLIMETRES_PER_INCH := 25.4

@export var host := "127.0.0.1"
@export var port := 9120
## A name in `--mix`; empty: leave the mix alone.
@export var texture := "corduroy"
## N; screens do not measure it.
@export var force_while_touching := 0.5

var udp := PacketPeerUDP.new()
var sequence := 0
var place := Vector2.ZERO
var touching := false


func _ready() -> void:
	# Every event of the pointer, not one a frame.
	Input.use_accumulated_input = false
	udp.connect_to_host(host, port)
	if texture != "":
		send_mix(texture, 1.0)


func _input(event: InputEvent) -> void:
	if event is InputEventScreenTouch:
		touching = event.pressed
		place = event.position
	elif event is InputEventMouseButton and event.button_index == MOUSE_BUTTON_LEFT:
		touching = event.pressed
		place = event.position
	elif event is InputEventScreenDrag or event is InputEventMouseMotion:
		place = event.position
	else:
		return
	send_motion()


func _process(_delta: float) -> void:
	# Even while nothing moves: 100 ms of silence is a lost finger.
	send_motion()


func send_motion() -> void:
	var millimetres := MILLIMETRES_PER_INCH / DisplayServer.screen_get_dpi()
	var message := _begun(MOTION_ADDRESS, MOTION_TYPES)
	message.put_float(place.x * millimetres)
	message.put_float(place.y * millimetres)
	message.put_float(NAN)  # the stream finds the speed from the positions
	message.put_float(force_while_touching if touching else 0.0)
	udp.put_packet(message.data_array)


## Weight of a texture, by the name that the stream knows it by.
func send_mix(named: String, weight: float) -> void:
	var message := _begun(MIX_ADDRESS, MIX_TYPES)
	_put_text(message, named)
	message.put_float(weight)
	udp.put_packet(message.data_array)


func _begun(address: String, types: String) -> StreamPeerBuffer:
	var message := StreamPeerBuffer.new()
	message.big_endian = true
	_put_text(message, address)
	_put_text(message, types)
	message.put_u32(sequence)
	message.put_double(Time.get_ticks_usec() / 1e6)
	sequence = (sequence + 1) & 0xFFFFFFFF  # of every message, of any kind
	return message


## A text ends with one to four zeros, so that its length is a multiple of four.
func _put_text(message: StreamPeerBuffer, text: String) -> void:
	var bytes := text.to_utf8_buffer()
	message.put_data(bytes)
	for _i in range(4 - bytes.size() % 4):
		message.put_u8(0)
