from .catalogue import find_sources as find_sources, open_source as open_source
from .logs import SensorLog as SensorLog, read_log as read_log, read_xdf as read_xdf
from .source import Block as Block, Source as Source, SourceEnded as SourceEnded, SourceLost as SourceLost
from .stream.gaps import filled as filled, gap_free as gap_free, gaps as gaps
from .stream.rate_estimate import RateEstimate as RateEstimate, estimate_rate as estimate_rate
