"""BACnet devices as a Modbus device on the loopback, for airsided (docs/bacnet.md)."""

__version__ = "0.1.0"
