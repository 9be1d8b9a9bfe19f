// SPDX-License-Identifier: Apache-2.0

import js from '@eslint/js';

const rules = {...js.configs.recommended.rules, 'prefer-const': ['error', {destructuring: 'all'}], eqeqeq: 'error',
  'no-unused-vars': 'error'};
const named = text => Object.fromEntries(text.split(' ').map(name => [name, 'readonly']));
const shared = 'console performance TextDecoder TextEncoder Blob Response URL WebAssembly setTimeout ' +
  'clearTimeout atob btoa CompressionStream DecompressionStream';
const page = named(`${shared} window document location history navigator innerWidth Node Option Worker DOMParser ` +
  'XMLSerializer IntersectionObserver ResizeObserver requestAnimationFrame cancelAnimationFrame postMessage');

export default [
  {files: ['web/*.js', 'report/pictures.js'], rules, languageOptions: {globals: {...page, onmessage: 'writable'}}},
  // Scripts that become one, after pictures.js: what one declares, another uses.
  {
    files: ['report/viewer.js', 'report/plots.js', 'report/page.js'], rules: {...rules, 'no-unused-vars': ['error', {vars: 'local'}], 'no-undef': 'off'},
    languageOptions: {sourceType: 'script'},
  },
  // Parts of the tests run in the page.
  {files: ['tests/live_page/*.js', 'bench/*.js', 'eslint.config.js'], rules,
    languageOptions: {globals: {...page, ...named('Buffer process Event File DataTransfer DragEvent')}}},
];
