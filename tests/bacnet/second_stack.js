// A BACnet/IP device of another library (node-bacnet), so that a misreading of the standard in bacpypes3 would show.
// node second_stack.js MODULE_FOLDER PORT: device 1201 with analog-input 3, binary-input 2 and the commandable
// analog-output 1. One line on standard output a write: priority and value, or `null`.
'use strict';

const path = require('path');
const bacnet = require(path.join(process.argv[2], 'node-bacnet'));
const { ErrorClass, ErrorCode } = bacnet.enum;

const NULL = 0, REAL = 4, BIT_STRING = 8, ENUMERATED = 9, ERROR = 105;
const PRESENT_VALUE = 85, PRIORITY_ARRAY = 87, STATUS_FLAGS = 111;
const DEFAULT = 24.0, LOWEST = 16;
const slots = Array(LOWEST).fill(null);
const objects = {
  '0:3': () => ({ type: REAL, value: 22.5 }),
  '3:2': () => ({ type: ENUMERATED, value: 1 }),
  '1:1': () => ({ type: REAL, value: slots.find((slot) => slot !== null) ?? DEFAULT }),
};

const device = new bacnet({ interface: '127.0.0.1', port: Number(process.argv[3]) });

function read(object, property) {
  const name = `${object.type}:${object.instance}`;
  if (!(name in objects)) return { error: [ErrorClass.OBJECT, ErrorCode.UNKNOWN_OBJECT] };
  if (property.id === PRESENT_VALUE) return { values: [objects[name]()] };
  if (property.id === STATUS_FLAGS) return { values: [{ type: BIT_STRING, value: { value: [0], bitsUsed: 4 } }] };
  if (property.id === PRIORITY_ARRAY && name === '1:1') {
    const all = slots.map((slot) => (slot === null ? { type: NULL, value: null } : { type: REAL, value: slot }));
    return { values: property.index >= 1 && property.index <= LOWEST ? [all[property.index - 1]] : all };
  }
  return { error: [ErrorClass.PROPERTY, ErrorCode.UNKNOWN_PROPERTY] };
}

device.on('readProperty', ({ header, service, invokeId, payload }) => {
  const found = read(payload.objectId, payload.property);
  if (found.error) device.errorResponse(header.sender, service, invokeId, ...found.error);
  else device.readPropertyResponse(header.sender, invokeId, payload.objectId, payload.property, found.values);
});

device.on('readPropertyMultiple', ({ header, invokeId, payload }) => {
  const answer = payload.properties.map(({ objectId, properties }) => ({
    objectId,
    values: properties.map((property) => {
      const { error, values } = read(objectId, property);
      const refusal = error && { type: ERROR, value: { type: 'BacnetError', errorClass: error[0], errorCode: error[1] } };
      return { property, value: refusal ? [refusal] : values };
    }),
  }));
  device.readPropertyMultipleResponse(header.sender, invokeId, answer);
});

device.on('writeProperty', ({ header, service, invokeId, payload }) => {
  const { priority, value: [one] } = payload.value;
  slots[(priority || LOWEST) - 1] = one.type === NULL ? null : one.value;
  console.log(`${priority} ${one.type === NULL ? 'null' : one.value}`);
  device.simpleAckResponse(header.sender, service, invokeId);
});

console.log('ready');
